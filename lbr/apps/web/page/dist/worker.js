// Keeps the page for a robot that is off or far: the files that it was built with, each checked by its digest, and nothing
// else. What the robot says is never kept. The build fills in the names.
const BUILD = "3f46526f897d0a2e";
/** @type {Record<string, string>} */
const FILES = JSON.parse("{\"assets/Behaviours-CimCaof-.js\":\"0c2bc1829aca4f99b86696ac18b85a4269d7190292c1b3a2cfeb7f3a1da9ce67\",\"assets/Behaviours-ju1TH5lu.css\":\"7df80eb0fe64b2ebddd196abb60e688fe2d0c3fdb01c7e65492934acb953265b\",\"assets/Below-D6u5c8Br.js\":\"3776175563696391ec64c2772a96264be83ab08f6c270c86d905079433dcfc95\",\"assets/Call-B5myZyvC.css\":\"9bd95ba7d1077c3c66775bc4757281e32365e5b943c7bc7624cd626d4792f397\",\"assets/Call-B8ZoTKYk.js\":\"7e05816d521530acbe419d596c6cac73b516490dc68fb61a3ce6cfd62729ee7c\",\"assets/Display-Ds1oz99O.js\":\"5fbc42ec349813755e9ce1a59e78c250ce46283b67243efdc85235a5268c5abf\",\"assets/Display-hbDRwTTd.css\":\"c83eeecb550859a06b9cd577a58e8c226d9ef24d37e0f7fb05ec1f901b52e67e\",\"assets/Drive-C7cR7G-d.js\":\"717c9a7ae6c1fce9ff4e117699e707726971d068d5143185938862408a3bb6a1\",\"assets/Drive-DA0oOCw8.css\":\"ca725096dee8c5c674a829996b919b267320060c09db2b5ba6b10b2fc80d0083\",\"assets/Joints-lQb6N3NF.js\":\"5e8cebd98b6dac7a7a3e5f010a5006b3d2c497b44f12d1e630e2fbb951878206\",\"assets/Lacking-BsE66JvF.js\":\"2ff0d3c9fd120e72a94f489c7a784d6720afb15ecbdc57aa65c51d62da717e7e\",\"assets/Lacking-CacvYTQJ.css\":\"c7c4f4a3d3af03716a518f6da6ec94b34d1ffc67385869d3316d0f32ce4ddef3\",\"assets/Log-Mtv2Fq0T.js\":\"a49cf98c287de1a0fe0bac039180a9c3d7b7d568439e9f695df2694772b1fa55\",\"assets/Motions-CaFlTiXz.css\":\"3ae2ef57347e7e60dc54ae7e27f44ce213a22abdda941217da9332eb71385719\",\"assets/Motions-KEboxyJR.js\":\"90318918dc52eb04f2ae3208e26418a5b2dc5bc31092dbc4bd29a8e3c9e9dd43\",\"assets/System-69YQKTGu.js\":\"be5162e8be2ad2d2bb01b873dcd3d973a53fe518e3fce507fb1af70e65baf721\",\"assets/System-DzGb0BSC.css\":\"24e170c69cd29e16f2088d6e853fad573a6835cf7d5736dadcb7954f3f03fb00\",\"assets/access-B0rs1E-b.js\":\"779d18a0e39d3430f85911164c6a1100ad1e01cae2a11cb6fb6558ad954e8d72\",\"assets/connection-BIJEwFev.js\":\"6add713d17ad251ed47024aa72f1c14fa35b94034819f5cabdf8352fb105d839\",\"assets/data-Cp-FLzTZ.js\":\"83fd7ed2ab4de4de0a19cf72ccdaba123b37c2a9c886cfb2598a2e95dac0d9d2\",\"assets/index-C68-3O2x.js\":\"906a69014993904022b191b4b7a05213806e9c12630064943d4ac99faa361b2f\",\"assets/index-DrfhNA8_.css\":\"2a05279a6876bf121c01175a22aee496b2429adc0521a0755d636d146c10bdb3\",\"assets/manage-D-9o7kUM.js\":\"36f167f83963abe898cb636c7848983fa60456bb678928bc890110a730570b10\",\"assets/model-BjR3jKsp.css\":\"e7b501306dc22d125bfd1c47dd9ad7e8822c5ccca5776778dd408da0b97061c5\",\"assets/model-UmYYoXg-.js\":\"8b54cba3fbb29654f4d0d82efa4c3529e57a3ed52f31b8d7729ec29f9316190c\",\"assets/news-D_IiFPK9.js\":\"6550a865e412f6495d83efa53fb768e6501011a1a975e0200f3927c547b04b24\",\"assets/stage-8EDcJWdY.js\":\"3277cf57274d73f580afe24037db14499dc7543627e5775a4af94e892782bff0\",\"assets/stream-C-_TUSUe.js\":\"7c18851533328827bc4635aefdd33096aa53fd671466aee901c159ca4f1f4f67\",\"assets/uPlot-CnsZ1jie.css\":\"0fd9465202f6dfceac29e67c17e5ac9fb1b7ba7615c1bb08782391b791d9f1e0\",\"assets/uPlot.esm-BScb58at.js\":\"068506d72590b07d0e53e012ff1541813c52c09bded848b3f97fcd1d4b0fd3b2\",\"favicon.ico\":\"eb66fde2ce87c9f33228184353f8a8c7ff0517cd76eaf9d6a94759bbd7276be9\",\"icon-192.png\":\"df4dde7d57f1963226b36d9501a3b173c02eddc858bef226ae0176dbb4b7ee19\",\"icon-512.png\":\"6e797a05bab65afa3472b6a2bbc42b2f7a33115ab789fa2403c592655657e04d\",\"icon-maskable.png\":\"98caea4e0138a5272161323354bea3585ecac298ff8576823258aeddee01a45f\",\"icon.svg\":\"d12d71c61b9b10bf6b04ba84d91497c272291cd0830c21d5ca98ce2c771fabf2\",\"index.html\":\"7c4573cc05084cdcbd06e0bf9aa7e05d1970ba6af315252326d6b8bf5d8d4f70\",\"page.webmanifest\":\"909a00587727949215a61974b50bfb8f15bda9c788e30bb4cdae5af19732dc86\"}");
/** What the page itself names: enough to say that the robot is away. */
const SHELL = JSON.parse("[\"index.html\",\"icon.svg\",\"icon-192.png\",\"page.webmanifest\",\"assets/index-C68-3O2x.js\",\"assets/access-B0rs1E-b.js\",\"assets/index-DrfhNA8_.css\"]");
const PREFIX = "lbr-page-";
const KEPT = PREFIX + BUILD;
const INDEX = "index.html";
/** A robot that says nothing for so long is taken for one that is away. */
const PATIENCE_MS = 4000;
const HEADERS = ["content-type", "content-security-policy", "referrer-policy", "x-content-type-options"];
const PLACE = new URL("./", location.href);

self.addEventListener("install", (event) => event.waitUntil(install()));
self.addEventListener("activate", (event) => event.waitUntil(activate()));
self.addEventListener("fetch", (event) => {
  const name = nameOf(event.request);
  if (name === null) return;
  event.respondWith(name === INDEX ? page(event.request) : part(name));
});

async function install() {
  await Promise.all(SHELL.map((name) => keep(name)));
  await self.skipWaiting();
}

async function activate() {
  const old = (await caches.keys()).filter((name) => name.startsWith(PREFIX) && name !== KEPT);
  await Promise.all(old.map((name) => caches.delete(name)));
  await self.clients.claim();
}

/** The built file that is asked for; null for all else, which this leaves to the browser. */
function nameOf(request) {
  const asked = new URL(request.url);
  if (request.method !== "GET" || asked.origin !== PLACE.origin || !asked.pathname.startsWith(PLACE.pathname)) return null;
  const name = asked.pathname.slice(PLACE.pathname.length);
  if (name === "") return request.mode === "navigate" ? INDEX : null;
  return asked.search === "" && name !== INDEX && Object.hasOwn(FILES, name) ? name : null;
}

/** The page as the robot has it now; the one that was kept where the robot is away. */
async function page(request) {
  const asked = fetch(request);
  asked.catch(() => undefined);
  try {
    const answer = await Promise.race([asked, new Promise((_, fail) => setTimeout(fail, PATIENCE_MS))]);
    if (answer.status < 500) return answer;
  } catch {
    // it is away
  }
  return (await kept(INDEX)) ?? asked;
}

async function part(name) {
  return (await kept(name)) ?? (await keep(name).catch(() => undefined)) ?? fetch(address(name));
}

const kept = async (name) => (await caches.open(KEPT)).match(address(name), { ignoreVary: true });
const address = (name) => new URL(name === INDEX ? "./" : name, PLACE).href;

/** Asks for a file and keeps it, if it is the one that this was built with. */
async function keep(name) {
  const answer = await fetch(address(name), { cache: "no-cache", headers: name === INDEX ? { Accept: "text/html" } : {} });
  const content = await answer.arrayBuffer();
  if (!answer.ok || (await sha256(content)) !== FILES[name]) throw new Error(`${name} is not the one of ${BUILD}`);
  const headers = HEADERS.filter((one) => answer.headers.has(one)).map((one) => [one, answer.headers.get(one)]);
  const found = new Response(content, { headers });
  await (await caches.open(KEPT)).put(address(name), found.clone());
  return found;
}

async function sha256(content) {
  const digest = new Uint8Array(await crypto.subtle.digest("SHA-256", content));
  return Array.from(digest, (one) => one.toString(16).padStart(2, "0")).join("");
}
