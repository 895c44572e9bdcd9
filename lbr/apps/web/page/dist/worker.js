// Keeps the page for a robot that is off or far: the files that it was built with, each checked by its digest, and nothing
// else. What the robot says is never kept. The build fills in the names.
const BUILD = "7a8db0b5afcb868e";
/** @type {Record<string, string>} */
const FILES = JSON.parse("{\"assets/Behaviours-Bzt6hcfg.js\":\"a11cff3c7e343345609da34d215bd2cd932d66b8c7ec2966a82d606b3725aa47\",\"assets/Behaviours-ju1TH5lu.css\":\"7df80eb0fe64b2ebddd196abb60e688fe2d0c3fdb01c7e65492934acb953265b\",\"assets/Below-RNjiz-_V.js\":\"9f8ab0aa02ac33bec4e8583fc37031e83d2ff2993121b3ecde78f9a73820e6df\",\"assets/Call-B5myZyvC.css\":\"9bd95ba7d1077c3c66775bc4757281e32365e5b943c7bc7624cd626d4792f397\",\"assets/Call-C6GHVm2v.js\":\"7d3e60077e55978616a11b1598c3d6bd8086516518a2f93e63fc8d5069e5d433\",\"assets/Display-DXibI7xM.js\":\"c1d7e8c949e163a8bf1af02896e079d6cf9059dd09162c3746409b243ef316bb\",\"assets/Display-hbDRwTTd.css\":\"c83eeecb550859a06b9cd577a58e8c226d9ef24d37e0f7fb05ec1f901b52e67e\",\"assets/Drive-CiGTg7f4.js\":\"898b1705ea8539f254f9bc27ff6c19a69d2c83d9185c7d9ba4148c09dc9fbad7\",\"assets/Drive-DA0oOCw8.css\":\"ca725096dee8c5c674a829996b919b267320060c09db2b5ba6b10b2fc80d0083\",\"assets/Joints-C8B_UVlN.js\":\"95fe767bc5f9d958364b6683cd64c3896c257e86a5549046eb8fc5a15a90c2a2\",\"assets/Lacking-CacvYTQJ.css\":\"c7c4f4a3d3af03716a518f6da6ec94b34d1ffc67385869d3316d0f32ce4ddef3\",\"assets/Lacking-Dixj9u9d.js\":\"2381df1f0cd119b95f95e81d71f5c6aa627cd90c32af54d40d901bb2430c6ed8\",\"assets/Log-BAkVTspv.js\":\"d3d5f320f93336609e1fa00523c406e5376fc8a3e6f950f788cca146a715f56b\",\"assets/Motions-CaFlTiXz.css\":\"3ae2ef57347e7e60dc54ae7e27f44ce213a22abdda941217da9332eb71385719\",\"assets/Motions-DXZ1jN_G.js\":\"bc7a2b8926f682d46ff98f5000fb694b13ee7b61e8059635595ed10ea04c9fbc\",\"assets/System-ChXDy4JZ.js\":\"a2e7d258eb657e61af9efbf776bc96f897e7dce5bda108fa72f47d2847f4534b\",\"assets/System-DzGb0BSC.css\":\"24e170c69cd29e16f2088d6e853fad573a6835cf7d5736dadcb7954f3f03fb00\",\"assets/access-3cI6PH5L.js\":\"cb8a903691d463f52eac78e36d329ade64aa49dfce63b9c97cb93834388bc2ff\",\"assets/connection-BMeTVRAf.js\":\"430a0cd0a016f95e0773341c8a7c7a1c6104cb06e2a8021d10d05066efe9ab7c\",\"assets/data-eQ_SnJcD.js\":\"c7929ff277cd1381b915f849114bce15be807c1a5cc24371afbf99d88f8a995e\",\"assets/index-BaEZsLos.js\":\"1ab8e6050f3f47933d510f173e730630d2f8dbb3023afd14d8cf6ef8ce30e793\",\"assets/index-DrfhNA8_.css\":\"2a05279a6876bf121c01175a22aee496b2429adc0521a0755d636d146c10bdb3\",\"assets/manage-uget3JMv.js\":\"17a51a5b09a7f389ac621a75e9c5b96726fa53d873d8aa5bc74b4695d7a8d519\",\"assets/model-BjR3jKsp.css\":\"e7b501306dc22d125bfd1c47dd9ad7e8822c5ccca5776778dd408da0b97061c5\",\"assets/model-CT6hRwZy.js\":\"191af1cfe968f60533f324e1faa3dbca9bc470426de0540db268d52981d36ecf\",\"assets/news-Co5v623X.js\":\"33802c46ffede7aa4d25cc0104f1e742cd30dcfb955d04b7d52c7284fa514828\",\"assets/parts-BvpMVtA_.js\":\"6152033d75afc07859443c6195759dfbb6ce747c8f05a66826f12b23b1e5a56c\",\"assets/stage-BpmTWtn9.js\":\"55cd33c2fe76bb2c77d5466fb7f8a741ec153fd5e1ee379124d8aec50b67ad83\",\"assets/stream-BYIjhStB.js\":\"2fa0d404388b156af28d9006d3d5b826a90b3348070bd38e9865d1fe5858a82d\",\"assets/uPlot-CnsZ1jie.css\":\"0fd9465202f6dfceac29e67c17e5ac9fb1b7ba7615c1bb08782391b791d9f1e0\",\"assets/uPlot.esm-BScb58at.js\":\"068506d72590b07d0e53e012ff1541813c52c09bded848b3f97fcd1d4b0fd3b2\",\"favicon.ico\":\"eb66fde2ce87c9f33228184353f8a8c7ff0517cd76eaf9d6a94759bbd7276be9\",\"icon-192.png\":\"df4dde7d57f1963226b36d9501a3b173c02eddc858bef226ae0176dbb4b7ee19\",\"icon-512.png\":\"6e797a05bab65afa3472b6a2bbc42b2f7a33115ab789fa2403c592655657e04d\",\"icon-maskable.png\":\"98caea4e0138a5272161323354bea3585ecac298ff8576823258aeddee01a45f\",\"icon.svg\":\"d12d71c61b9b10bf6b04ba84d91497c272291cd0830c21d5ca98ce2c771fabf2\",\"index.html\":\"a9b5d2b392e076aca94862cd723b223ab3b142ca591306a9a7a48ba3fff0998f\",\"page.webmanifest\":\"909a00587727949215a61974b50bfb8f15bda9c788e30bb4cdae5af19732dc86\"}");
/** What the page itself names: enough to say that the robot is away. */
const SHELL = JSON.parse("[\"index.html\",\"icon.svg\",\"icon-192.png\",\"page.webmanifest\",\"assets/index-BaEZsLos.js\",\"assets/access-3cI6PH5L.js\",\"assets/parts-BvpMVtA_.js\",\"assets/index-DrfhNA8_.css\"]");
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
