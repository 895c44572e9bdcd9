// Keeps the page for a robot that is off or far: the files that it was built with, each checked by its digest, and nothing
// else. What the robot says is never kept. The build fills in the names.
const BUILD = "791b70445e34745d";
/** @type {Record<string, string>} */
const FILES = JSON.parse("{\"assets/Behaviours-ju1TH5lu.css\":\"7df80eb0fe64b2ebddd196abb60e688fe2d0c3fdb01c7e65492934acb953265b\",\"assets/Behaviours-wfoxUoil.js\":\"9fe04fb22815f853fe0346c9d7830b18bb40ff597be77ea34565ff51ca2870b7\",\"assets/Below-9Y6zregn.js\":\"d211006867ec820e8dcd9e4ff7c84adc699ce0e0846454a1b9c4ffeb0277b99f\",\"assets/Call-B5myZyvC.css\":\"9bd95ba7d1077c3c66775bc4757281e32365e5b943c7bc7624cd626d4792f397\",\"assets/Call-CcrmwQX7.js\":\"dfcd0017928d90dd232f70c161d2059b9bb1607b8857d062231f1880c6b4e2e5\",\"assets/Display-BH6jqd6A.js\":\"46ac8d14310c86296b4e04213b46663918557ffc0331d125c8a6b8b043543f20\",\"assets/Display-NQ95WRFc.css\":\"7ac5d0b42865202760c3cc3fcdeb9f6aae740f24e27ee4d65c06575e4ae56193\",\"assets/Drive-DA0oOCw8.css\":\"ca725096dee8c5c674a829996b919b267320060c09db2b5ba6b10b2fc80d0083\",\"assets/Drive-DMKytcW3.js\":\"8999fc3dbf738d9c735c91544afa1242e699678ded758e401c9122a4b95cc262\",\"assets/Joints-CNNQb5UJ.js\":\"ab2d85895011c278c6652b15771ff04b5003330dbfeabfa396bb486a584bb33a\",\"assets/Lacking-CacvYTQJ.css\":\"c7c4f4a3d3af03716a518f6da6ec94b34d1ffc67385869d3316d0f32ce4ddef3\",\"assets/Lacking-DDQFDISp.js\":\"01e8c19ffb71d336a0bb260c0d2f2d2fe91840803611d8f02608f8ac4eacfe7f\",\"assets/Log-N227YEkK.js\":\"ca41fe6c114ef1e4372d32e8cf3e571113a26defb84b83eb8b255868f97c95fb\",\"assets/Motions-CYQA3Jfn.js\":\"3c63bef5cc66c903bc23ce48ea8a62e812c74a52d7471bbfd4ffdaa0465e2be1\",\"assets/Motions-CaFlTiXz.css\":\"3ae2ef57347e7e60dc54ae7e27f44ce213a22abdda941217da9332eb71385719\",\"assets/System-CTwAaRyK.js\":\"e79b7310b101a14926e348e6a8fc6c26e6ec39f90f49bd940e1e29f67fafae83\",\"assets/System-DzGb0BSC.css\":\"24e170c69cd29e16f2088d6e853fad573a6835cf7d5736dadcb7954f3f03fb00\",\"assets/access-QUaLFx5f.js\":\"b7c5e8e9d0064da82d3ffa20ca2a1ed2649c918da0bd9623cbea1c2097102e74\",\"assets/connection-B6edgPSu.js\":\"5742d99760194bb171d80ac9ec2beb996a10e08cff6365286a0897ab060dae19\",\"assets/data-CpihXmn3.js\":\"e55b9f65144ac8b9223e0658c1203f68fca7ea189ee50a278b16f2d2ccfc4576\",\"assets/index-Cv_h4rR9.js\":\"562bf040f7aac955c504709881eecbf41aa57b51260033dfea33e51da67e50cf\",\"assets/index-DrfhNA8_.css\":\"2a05279a6876bf121c01175a22aee496b2429adc0521a0755d636d146c10bdb3\",\"assets/manage-BAZH8rL1.js\":\"38114137adefa001de84d5dea12eac1fddceb22dd28e260ebc61be0a9817c76c\",\"assets/model-BjR3jKsp.css\":\"e7b501306dc22d125bfd1c47dd9ad7e8822c5ccca5776778dd408da0b97061c5\",\"assets/model-DyNg_Hcd.js\":\"cd800827a141f6f7a50fc4a3aa67f74ece5c5150ca6dbd01d9ee6ba162fe09cd\",\"assets/news-B2ixpiVY.js\":\"e48e5f8437693bcb70a74df86dfaaa61511576994ffb772af795d1aabf39380a\",\"assets/stage-rPBp01Qs.js\":\"d4d27a6c5013ab470a3059bba73a4ad9108a62d1cfea107a65609e28c83d27d0\",\"assets/stream-D86DTz1E.js\":\"e081e84ef13d5bb3bf53bdd3369f8446e720dad7a0ebbcba155a28739ebede6d\",\"assets/uPlot-CnsZ1jie.css\":\"0fd9465202f6dfceac29e67c17e5ac9fb1b7ba7615c1bb08782391b791d9f1e0\",\"assets/uPlot.esm-BScb58at.js\":\"068506d72590b07d0e53e012ff1541813c52c09bded848b3f97fcd1d4b0fd3b2\",\"favicon.ico\":\"eb66fde2ce87c9f33228184353f8a8c7ff0517cd76eaf9d6a94759bbd7276be9\",\"icon-192.png\":\"df4dde7d57f1963226b36d9501a3b173c02eddc858bef226ae0176dbb4b7ee19\",\"icon-512.png\":\"6e797a05bab65afa3472b6a2bbc42b2f7a33115ab789fa2403c592655657e04d\",\"icon-maskable.png\":\"98caea4e0138a5272161323354bea3585ecac298ff8576823258aeddee01a45f\",\"icon.svg\":\"d12d71c61b9b10bf6b04ba84d91497c272291cd0830c21d5ca98ce2c771fabf2\",\"index.html\":\"127adea6d565258a40b1027076178a34e8e6f90ab440870613aa8646384ee54c\",\"page.webmanifest\":\"909a00587727949215a61974b50bfb8f15bda9c788e30bb4cdae5af19732dc86\"}");
/** What the page itself names: enough to say that the robot is away. */
const SHELL = JSON.parse("[\"index.html\",\"icon.svg\",\"icon-192.png\",\"page.webmanifest\",\"assets/index-Cv_h4rR9.js\",\"assets/access-QUaLFx5f.js\",\"assets/index-DrfhNA8_.css\"]");
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
