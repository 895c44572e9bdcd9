// Keeps the page for a robot that is off or far: the files that it was built with, each checked by its digest, and nothing
// else. What the robot says is never kept. The build fills in the names.
const BUILD = "f98a7c5dbfa41de7";
/** @type {Record<string, string>} */
const FILES = JSON.parse("{\"assets/Behaviours-BVdZCPY0.js\":\"f03b7b248ca84b7c940d20b52ab71d7879b9ee31c17f662cf50a4afe3ab2f92f\",\"assets/Behaviours-ju1TH5lu.css\":\"7df80eb0fe64b2ebddd196abb60e688fe2d0c3fdb01c7e65492934acb953265b\",\"assets/Below--NA9Z5vr.js\":\"1b29bb51b3717c6ddcdd192750e5c93682d95c7d0f1d22f64cac4d4bb718f1be\",\"assets/Call-B5myZyvC.css\":\"9bd95ba7d1077c3c66775bc4757281e32365e5b943c7bc7624cd626d4792f397\",\"assets/Call-CYxnmUT2.js\":\"530a888b1a5f53615aada2ac3e9719505d6e05e9f0faba0a7441ac71fffcb14d\",\"assets/Display-CMbMBufU.js\":\"c375435e191bf82ff1bebf32b00fe02861e52893a74331ee19b9b9fea1557355\",\"assets/Display-hbDRwTTd.css\":\"c83eeecb550859a06b9cd577a58e8c226d9ef24d37e0f7fb05ec1f901b52e67e\",\"assets/Drive-DA0oOCw8.css\":\"ca725096dee8c5c674a829996b919b267320060c09db2b5ba6b10b2fc80d0083\",\"assets/Drive-xEfui31E.js\":\"2656424b94f0a811cda04237339c2b77c8b24c58c93acb3820149f3d71811089\",\"assets/Joints-vVr3TBT8.js\":\"02d7099cea1a24090cd8ee00cbc11dfdb975c0ba52049ee8979f0cc639d4d19e\",\"assets/Lacking-36WnMpFY.js\":\"1d637937edf6c706dbdba065176d28347e4bdefd6ad0709a7eb3905d3b7779b0\",\"assets/Lacking-CacvYTQJ.css\":\"c7c4f4a3d3af03716a518f6da6ec94b34d1ffc67385869d3316d0f32ce4ddef3\",\"assets/Log-C3a9zsn1.js\":\"cb0dcfdc47b97dbf5fd9d4f4a0f253e91c5c5caf10bd14c344294a3906bb0a28\",\"assets/Motions-CaFlTiXz.css\":\"3ae2ef57347e7e60dc54ae7e27f44ce213a22abdda941217da9332eb71385719\",\"assets/Motions-JTB2wzf0.js\":\"6bd86d63c437993f295a3d49d78a82e308c45a6fc4615a0dc44d6e0550e8c942\",\"assets/System-BZ8p85I5.js\":\"e1c2e4ded5dafbbfb92960d52df81fc08a3ccabe34b266d8a45623a0c3a50498\",\"assets/System-DzGb0BSC.css\":\"24e170c69cd29e16f2088d6e853fad573a6835cf7d5736dadcb7954f3f03fb00\",\"assets/access-CDdFy0RP.js\":\"e6251fffbfcadce9a4379e494f348bde33ee768212c400f07bd8eff39437eddc\",\"assets/connection-COs4CRlx.js\":\"e791acecbf114dafdb2c3229eeddbbc9bd45e53777f4ac9f317e1804d173fd3c\",\"assets/data-Dn-BKxZM.js\":\"2fc095d1153a4a123e5da8c8c965aac4a866f21081f9f8421ecb795e13b502f0\",\"assets/index-BG0EO9dt.js\":\"c9dfc91c3e73e5d26aee3a7ec0eb097e926349383f6debd6740fc0a3f1cbd200\",\"assets/index-DrfhNA8_.css\":\"2a05279a6876bf121c01175a22aee496b2429adc0521a0755d636d146c10bdb3\",\"assets/manage-DTcDM9vP.js\":\"837023d8b66f6922903de6ef051f2403aed528d1b599ae286f1322490c975c36\",\"assets/model-BjR3jKsp.css\":\"e7b501306dc22d125bfd1c47dd9ad7e8822c5ccca5776778dd408da0b97061c5\",\"assets/model-CsbA7K2J.js\":\"845229181f70210de85814beb0bca6119c468e403e1d3b2598d6614bc4e96de6\",\"assets/news-hX8dAKvB.js\":\"c79b5d5e0fa391b1f7700cac9205e7330b58c24fcbbb1e3ed659e0e2043c0bdb\",\"assets/parts-5TamLz9m.js\":\"25c60e3fb0151f0a9ecb7d4c935ed39909fbd3e6fd513b7c0fc25eb8420382ea\",\"assets/stage-g2q4tIjs.js\":\"14099d0166a604578d29b7dc7d96291049621d7b435c73e8ded33224fa2720b7\",\"assets/stream-CkntvB03.js\":\"a5da9aacc644690ea71b170fa88aa23af7af42511f973af16c677c48a054e2db\",\"assets/uPlot-CnsZ1jie.css\":\"0fd9465202f6dfceac29e67c17e5ac9fb1b7ba7615c1bb08782391b791d9f1e0\",\"assets/uPlot.esm-BScb58at.js\":\"068506d72590b07d0e53e012ff1541813c52c09bded848b3f97fcd1d4b0fd3b2\",\"favicon.ico\":\"eb66fde2ce87c9f33228184353f8a8c7ff0517cd76eaf9d6a94759bbd7276be9\",\"icon-192.png\":\"df4dde7d57f1963226b36d9501a3b173c02eddc858bef226ae0176dbb4b7ee19\",\"icon-512.png\":\"6e797a05bab65afa3472b6a2bbc42b2f7a33115ab789fa2403c592655657e04d\",\"icon-maskable.png\":\"98caea4e0138a5272161323354bea3585ecac298ff8576823258aeddee01a45f\",\"icon.svg\":\"d12d71c61b9b10bf6b04ba84d91497c272291cd0830c21d5ca98ce2c771fabf2\",\"index.html\":\"0da208389fd377d97e834ce4553acf300193e01257dedc6307016c8cfd0669c2\",\"page.webmanifest\":\"909a00587727949215a61974b50bfb8f15bda9c788e30bb4cdae5af19732dc86\"}");
/** What the page itself names: enough to say that the robot is away. */
const SHELL = JSON.parse("[\"index.html\",\"icon.svg\",\"icon-192.png\",\"page.webmanifest\",\"assets/index-BG0EO9dt.js\",\"assets/access-CDdFy0RP.js\",\"assets/parts-5TamLz9m.js\",\"assets/index-DrfhNA8_.css\"]");
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
