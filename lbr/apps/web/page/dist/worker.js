// Keeps the page for a robot that is off or far: the files that it was built with, each checked by its digest, and nothing
// else. What the robot says is never kept. The build fills in the names.
const BUILD = "78dae8241214ebab";
/** @type {Record<string, string>} */
const FILES = JSON.parse("{\"assets/Behaviours-BgDrVOTN.js\":\"0467325836695b6e5175b32345037f7586bb30b51dd2e3760c282855246125b2\",\"assets/Behaviours-CW6UGM9H.css\":\"f8ec05f55e6ffeb2c0ecf622c8f86b9bcd1e9fc4197c1fb4ed8135c322d9d1a4\",\"assets/Below-DYcfO6g8.js\":\"2cc268dc88fc717ebaf91b31a2c61bb076a1b88531b78c9338afe629e2073c2d\",\"assets/Call-BH-FlvRt.css\":\"72c27a044611bd5e73568c62521730576fefce8c2a7bc35fb38ab268f89da215\",\"assets/Call-DzgDwW0Q.js\":\"db83c2e1aca01abf65f5b9f40d0a087b97ab4e4971c032635184772059d6611d\",\"assets/Display-CO45VEnX.js\":\"450ab54bc0a9868a81b4416badf6719fd9e83bcb552127a85be9a4728addb3b3\",\"assets/Display-hbDRwTTd.css\":\"c83eeecb550859a06b9cd577a58e8c226d9ef24d37e0f7fb05ec1f901b52e67e\",\"assets/Drive-CguKo-Or.css\":\"502d412c4055f2c0f7d9d3a0c36f04fb07c4402f07fc5410662c1d7eb0c43be9\",\"assets/Drive-xlrhxBzq.js\":\"6fbbf2921e559894f4af632ac5c6b3a03bff1045934df6b59125204ce7a8ccdc\",\"assets/Joints-DcDUdQR4.js\":\"526af672fa712bdea43d58d0a247e95fed24301ae6e6565c067c4c4f6188c114\",\"assets/Lacking-CacvYTQJ.css\":\"c7c4f4a3d3af03716a518f6da6ec94b34d1ffc67385869d3316d0f32ce4ddef3\",\"assets/Lacking-Mj2f__oT.js\":\"340baa2aefe50ec54cef030e2628352cc4751e233925c3fa3cf837930dbe7c59\",\"assets/Log-CBrtzCRW.js\":\"3df765752a3eb95b1184128d787da034c642fd85e8c99d18360637a006844ac9\",\"assets/Motions-BK3Rrsdu.css\":\"5423ace46b17bffaa4bdfbcf2303eaf0fa3f1a14b9693db32015687986025d11\",\"assets/Motions-CZgCwr0d.js\":\"067c3d9b6bfe22d16e3a994a4f9f5d2aff57ed2c03dbbe031eee35a0eea946a7\",\"assets/System-Bu9_xfDb.js\":\"f694f769014a03a45f4df506bcc088300f1e22d32d86dd2b237c36b6015b30f4\",\"assets/System-CAGU8Dof.css\":\"ae933e9c36299104bd16c32c77243303a9aac415f91195177bf4a3e59a11cf9e\",\"assets/access-gmDrJIRZ.js\":\"bf83a1aef4d9210e697a011167faeed0bace7d874dc92d107c8eee8047c935af\",\"assets/connection-S_iw3T6q.js\":\"8bc56ff1409dbe006422c5e79db752754585f9147f1a5db88f664911f90ff556\",\"assets/data-CRs1xkIP.js\":\"ac727a0f2186d54f3d900b3d59511a4ef6fe035ebcb92c471dcb0ffd7bece916\",\"assets/index-CdOJPFtC.js\":\"36cfa9b0186b5fed40b98a82899ebf17526f62d33522ffd364d96668c38dfd5a\",\"assets/index-DWdO08Zv.css\":\"0cd8bc74e233b4a804728e823f79b07fd598f349fd123c2d8f28fb5db89f60d2\",\"assets/manage-Bucf1Lde.js\":\"7ed24312e5d38a84d919794ddcd8089bf55b7cfcda4dd32d8141176fee2e5435\",\"assets/model-B_O0fmDU.css\":\"282b1cc84bddd70cb9bb54d0f6f1e2d6f0f6fbad8b72b2187e9001ef812ca75e\",\"assets/model-FU54mgMV.js\":\"0a627edd00adfc11fff1bb8b9583cabff9c3ac10c2ccbc0ddd12c11e4172039a\",\"assets/news-CUfQmTMt.js\":\"ecec3c8fb7e898eb69d0c7b1374c8f4163dcea64a0278a6c7ad9c2a9c335843a\",\"assets/parts-OEe3uIrG.js\":\"ea4e1893cf504af0f317c3f691ba938f52ba966b7d8f311b29fa6ab06cca5512\",\"assets/stage--EiJ83sp.js\":\"ac0a1a58d98bf6cbbd35f3d768473f5bb221a285f8b6c7d46fa98ec7ffaf8bcd\",\"assets/stream-YPDEIokw.js\":\"a46c81600b7f4361e88cedb756f0a3eb2fdc142cd481400b95f006f1bfc3ea70\",\"assets/uPlot-CnsZ1jie.css\":\"0fd9465202f6dfceac29e67c17e5ac9fb1b7ba7615c1bb08782391b791d9f1e0\",\"assets/uPlot.esm-BScb58at.js\":\"068506d72590b07d0e53e012ff1541813c52c09bded848b3f97fcd1d4b0fd3b2\",\"favicon.ico\":\"eb66fde2ce87c9f33228184353f8a8c7ff0517cd76eaf9d6a94759bbd7276be9\",\"icon-192.png\":\"df4dde7d57f1963226b36d9501a3b173c02eddc858bef226ae0176dbb4b7ee19\",\"icon-512.png\":\"6e797a05bab65afa3472b6a2bbc42b2f7a33115ab789fa2403c592655657e04d\",\"icon-maskable.png\":\"98caea4e0138a5272161323354bea3585ecac298ff8576823258aeddee01a45f\",\"icon.svg\":\"d12d71c61b9b10bf6b04ba84d91497c272291cd0830c21d5ca98ce2c771fabf2\",\"index.html\":\"181dc6279545eb612c11d60ff5aaf74b0d958ef0177785441aa5e9e1b3382e3b\",\"page.webmanifest\":\"909a00587727949215a61974b50bfb8f15bda9c788e30bb4cdae5af19732dc86\"}");
/** What the page itself names: enough to say that the robot is away. */
const SHELL = JSON.parse("[\"index.html\",\"icon.svg\",\"icon-192.png\",\"page.webmanifest\",\"assets/index-CdOJPFtC.js\",\"assets/access-gmDrJIRZ.js\",\"assets/parts-OEe3uIrG.js\",\"assets/index-DWdO08Zv.css\"]");
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
