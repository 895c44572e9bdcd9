// Keeps the page for a robot that is off or far: the files that it was built with, each checked by its digest, and nothing
// else. What the robot says is never kept. The build fills in the names.
const BUILD = "8281facc4765aba0";
/** @type {Record<string, string>} */
const FILES = JSON.parse("{\"assets/Behaviours-BzvGd6sS.js\":\"4570f509b7565868010c7cf65b88c088f9e88282535fd04febb150f0b182a2b3\",\"assets/Behaviours-ju1TH5lu.css\":\"7df80eb0fe64b2ebddd196abb60e688fe2d0c3fdb01c7e65492934acb953265b\",\"assets/Below-CFifP948.js\":\"15c21242bca862320f463599f158abe1c901ef731fecaf484ff15f2f7b0a3b64\",\"assets/Call-B5myZyvC.css\":\"9bd95ba7d1077c3c66775bc4757281e32365e5b943c7bc7624cd626d4792f397\",\"assets/Call-BFjD_yVk.js\":\"9fbd4b31e48365ac6f8218ea806970ff6be3b6a0699c5995800243762c532014\",\"assets/Display-C5F3U8vb.js\":\"a559bc17c11e4394627ca2d14cc43b7274fbb63638d5226e572167f9d21219ab\",\"assets/Display-hbDRwTTd.css\":\"c83eeecb550859a06b9cd577a58e8c226d9ef24d37e0f7fb05ec1f901b52e67e\",\"assets/Drive-BeT1V8pS.js\":\"9559b75ec984d2a037e5b94c5cfd2bc0c123cc0bc97134a9a9e0c3eb57c6d756\",\"assets/Drive-DA0oOCw8.css\":\"ca725096dee8c5c674a829996b919b267320060c09db2b5ba6b10b2fc80d0083\",\"assets/Joints-BNiwQ_1B.js\":\"54e73862e6478e4116f6a839efee503d77458b408c1d6db997887112ac06eea6\",\"assets/Lacking-CKD-laDv.js\":\"c313a2c96f8aed7f22dc6ef20e57c99009c28af52010565d70c56ac270588304\",\"assets/Lacking-CacvYTQJ.css\":\"c7c4f4a3d3af03716a518f6da6ec94b34d1ffc67385869d3316d0f32ce4ddef3\",\"assets/Log-B29wj4nB.js\":\"7ca73a4a9d5de104606c1c476fcd53ecc4585d7e457a82f1964a81d281b93ee2\",\"assets/Motions-CaFlTiXz.css\":\"3ae2ef57347e7e60dc54ae7e27f44ce213a22abdda941217da9332eb71385719\",\"assets/Motions-fSrpyGTy.js\":\"d836719399d6d40617aeeb4c67a2787d8ab72bf09765ea7a0d281b96f9c734bc\",\"assets/System-DzGb0BSC.css\":\"24e170c69cd29e16f2088d6e853fad573a6835cf7d5736dadcb7954f3f03fb00\",\"assets/System-_H_FzyBi.js\":\"dd44af33e83af8e9c20420930000135937c5118e811e8c687001718e7ccc3e03\",\"assets/access-Bo-Vzv95.js\":\"93cad159bb2a564f41a5a5c4b1689cd0717639d4b3800ef503b3fffbb2ddd6dc\",\"assets/connection-Dvo7fElK.js\":\"f6aa47b649d7d280c6ab14159e23a5defce7b27b39081131edecf409c8bdaf44\",\"assets/data-BsHob8hX.js\":\"3a8e5d662ce9919839c5c780c1cc3bb157797e8cae34a149435b397bfe0d786c\",\"assets/index-DrfhNA8_.css\":\"2a05279a6876bf121c01175a22aee496b2429adc0521a0755d636d146c10bdb3\",\"assets/index-bT-wLQAn.js\":\"bb1d7956e205d104b7fe68d1104fe574e05c07543cbe8c217a951deb5d2a2bcf\",\"assets/manage-CEQaofQo.js\":\"527d694be8a9d69ff5e97b97614459421759768babefbaceb0c10f57debce253\",\"assets/model-BjR3jKsp.css\":\"e7b501306dc22d125bfd1c47dd9ad7e8822c5ccca5776778dd408da0b97061c5\",\"assets/model-XdIelClQ.js\":\"76195bfd3be14d71717537427da7b52c51c85fab56460396ecceb60d8981f785\",\"assets/news-C2RNBHcz.js\":\"3e3793d3535a5601ca132377b10d1a9c80749f98f1486745c13b5d8244f486e7\",\"assets/stage-VcduCHQI.js\":\"6bcf10565ab43ece25bb5beece0336dba5eb1608a9cce6a58b21f0bb02bd4f0c\",\"assets/stream-f6owPOr_.js\":\"130644486805ee7d4f2027206737a8cda01a121566e44b414b16ce02c1fa2bda\",\"assets/uPlot-CnsZ1jie.css\":\"0fd9465202f6dfceac29e67c17e5ac9fb1b7ba7615c1bb08782391b791d9f1e0\",\"assets/uPlot.esm-BScb58at.js\":\"068506d72590b07d0e53e012ff1541813c52c09bded848b3f97fcd1d4b0fd3b2\",\"favicon.ico\":\"eb66fde2ce87c9f33228184353f8a8c7ff0517cd76eaf9d6a94759bbd7276be9\",\"icon-192.png\":\"df4dde7d57f1963226b36d9501a3b173c02eddc858bef226ae0176dbb4b7ee19\",\"icon-512.png\":\"6e797a05bab65afa3472b6a2bbc42b2f7a33115ab789fa2403c592655657e04d\",\"icon-maskable.png\":\"98caea4e0138a5272161323354bea3585ecac298ff8576823258aeddee01a45f\",\"icon.svg\":\"d12d71c61b9b10bf6b04ba84d91497c272291cd0830c21d5ca98ce2c771fabf2\",\"index.html\":\"41f2b5f9fdb7be60578619987c802645d608cf06d57947eaf90299fa917f735b\",\"page.webmanifest\":\"909a00587727949215a61974b50bfb8f15bda9c788e30bb4cdae5af19732dc86\"}");
/** What the page itself names: enough to say that the robot is away. */
const SHELL = JSON.parse("[\"index.html\",\"icon.svg\",\"icon-192.png\",\"page.webmanifest\",\"assets/index-bT-wLQAn.js\",\"assets/access-Bo-Vzv95.js\",\"assets/index-DrfhNA8_.css\"]");
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
