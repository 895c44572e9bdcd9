// Keeps the page for a robot that is off or far: the files that it was built with, each checked by its digest, and nothing
// else. What the robot says is never kept. The build fills in the names.
const BUILD = "8e62395564b37e04";
/** @type {Record<string, string>} */
const FILES = JSON.parse("{\"assets/Behaviours-CW6UGM9H.css\":\"f8ec05f55e6ffeb2c0ecf622c8f86b9bcd1e9fc4197c1fb4ed8135c322d9d1a4\",\"assets/Behaviours-D9YzcXee.js\":\"e1a577c3137d58c2cfdf9190dff84ea510a2d6696682b7e020922a02ae6571d3\",\"assets/Call-BH-FlvRt.css\":\"72c27a044611bd5e73568c62521730576fefce8c2a7bc35fb38ab268f89da215\",\"assets/Call-Z1BSc0WU.js\":\"083cf63f0554843d735582356c033d4b4c952019e2e287c860118c44ed76d5d3\",\"assets/Display-CWWugpTc.js\":\"ac847aeb9bdf022927900736f57ab7c5e1b8bf8d43922b69c5f861c587017e95\",\"assets/Display-hbDRwTTd.css\":\"c83eeecb550859a06b9cd577a58e8c226d9ef24d37e0f7fb05ec1f901b52e67e\",\"assets/Drive-C8Tq45Zd.css\":\"08011867db62c8cb3b9c12a4042ef6bb9ec597d6a95f74b6b314a7d790941e10\",\"assets/Drive-cl7R7OPT.js\":\"496dfcdadeeb3ac0b7502d6d506d05148d4f866965150f361b82b501d61110e9\",\"assets/Joints-CFuXtvOF.js\":\"3ebe587980146d75c22286bdad16147ade6ce884a5a3db4a77c622587688bee6\",\"assets/Motions-CoUeG6QQ.css\":\"c7405ed80447ef97051d5de59d8b24ad9cce70b4956e89b2333a1e4c142f4c38\",\"assets/Motions-y1M6ZH8H.js\":\"eba7eec0062a8993ca034d35d4d5d13ad12a39f222a1829917f654529b7cb204\",\"assets/System-BQs2N58n.js\":\"7c44ff570f7bc5ff394f7a78ba34d1e56a9cfb078a21f68539c1e3103bc6d01d\",\"assets/System-xJZzRxg6.css\":\"2d83ae9f9a033c027a167077f5d405b0a8a9e40b97a28f57c7d6949cb04c1462\",\"assets/index-37QKiDEs.js\":\"b3c495389a0267ceb5507b2e8b3bda8c3e0b42fce8d4b22abbd540f6751ba5f4\",\"assets/index-DIAhJi-2.css\":\"d0e765591aba08caf1fe52118718837f19e698789e9e691ba5b71b02e6cde5be\",\"assets/manage-BagrE_tM.js\":\"5abe3cd1dbb89e51cb9e269d09a83e00f6a73ffdd1e6f5fa13d310907cd5a37e\",\"assets/model-Bx7yEgVu.css\":\"802b384b1a54f70974f60851ef6bb609817b19f6c569ccb15816cb9f8a7b4e9f\",\"assets/model-ByHIgB3F.js\":\"7f33adfde00653f48a9831174aa7a2adebe7785835064be8bdb7aa8ae15be076\",\"assets/news-C3ldS8Yc.js\":\"c1934c77e822db437545d80afa2038e891c9d300732946584d99c82b8ccc57c9\",\"assets/parts-CivbtLuw.js\":\"eb755e176b03248396225b7ef6235011beef3f337051af9b2943f5fca8456206\",\"assets/saving-DbPjuOQb.js\":\"94d1a2e76767f7fdfe2e444b94c2326a340904bc4ede0b5445dbbf7236821d66\",\"assets/stage-MI90iQ0p.js\":\"2eef83e6884fd877b164cbcda224cdfc7a718c333183ba2bf544b213c222853d\",\"assets/stream-CbJ_n_x3.js\":\"2b2b6d4ea6c0a3c301241bd15c2b7a0174df1115381bbd4f484162e457eb7719\",\"assets/uPlot-CnsZ1jie.css\":\"0fd9465202f6dfceac29e67c17e5ac9fb1b7ba7615c1bb08782391b791d9f1e0\",\"assets/uPlot.esm-BScb58at.js\":\"068506d72590b07d0e53e012ff1541813c52c09bded848b3f97fcd1d4b0fd3b2\",\"favicon.ico\":\"eb66fde2ce87c9f33228184353f8a8c7ff0517cd76eaf9d6a94759bbd7276be9\",\"icon-192.png\":\"df4dde7d57f1963226b36d9501a3b173c02eddc858bef226ae0176dbb4b7ee19\",\"icon-512.png\":\"6e797a05bab65afa3472b6a2bbc42b2f7a33115ab789fa2403c592655657e04d\",\"icon-maskable.png\":\"98caea4e0138a5272161323354bea3585ecac298ff8576823258aeddee01a45f\",\"icon.svg\":\"d12d71c61b9b10bf6b04ba84d91497c272291cd0830c21d5ca98ce2c771fabf2\",\"index.html\":\"3e4544b9d35da6d0213721a13ba2aa90681fca0cf1eef0c9649e757deab4ce5f\",\"page.webmanifest\":\"909a00587727949215a61974b50bfb8f15bda9c788e30bb4cdae5af19732dc86\"}");
/** What the page itself names: enough to say that the robot is away. */
const SHELL = JSON.parse("[\"index.html\",\"icon.svg\",\"icon-192.png\",\"page.webmanifest\",\"assets/index-37QKiDEs.js\",\"assets/parts-CivbtLuw.js\",\"assets/index-DIAhJi-2.css\"]");
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
