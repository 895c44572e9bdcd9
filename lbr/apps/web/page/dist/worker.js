// Keeps the page for a robot that is off or far: the files that it was built with, each checked by its digest, and nothing
// else. What the robot says is never kept. The build fills in the names.
const BUILD = "bf9103d70658e887";
/** @type {Record<string, string>} */
const FILES = JSON.parse("{\"assets/Behaviours-CW6UGM9H.css\":\"f8ec05f55e6ffeb2c0ecf622c8f86b9bcd1e9fc4197c1fb4ed8135c322d9d1a4\",\"assets/Behaviours-CxF7z9VO.js\":\"13ff5cbae0aae27023aac257077f4b9389b85306f7f5f1818dc9d6119b264d59\",\"assets/Call-BH-FlvRt.css\":\"72c27a044611bd5e73568c62521730576fefce8c2a7bc35fb38ab268f89da215\",\"assets/Call-D__jBSy1.js\":\"5c2d5e64500dabe842e9e3b31107c8ace2d04aa7b3f31b0e74a2d11b8f08cc26\",\"assets/Display-CE2h7PrN.js\":\"5769109afc4eb515867a1edbc26991210aa10ca1182de16f776dc54abc341636\",\"assets/Display-hbDRwTTd.css\":\"c83eeecb550859a06b9cd577a58e8c226d9ef24d37e0f7fb05ec1f901b52e67e\",\"assets/Drive-4osGqLV4.css\":\"068027e6e3fb156d06aa1ca17041a0e63f7ca8ffd7c579b59c58e6deb0f9802e\",\"assets/Drive-CEW2YSFO.js\":\"ab1002fdc15d9a4e8751e52ca7204a80c7df7117a5efe65a443ca9f27fcd6fb5\",\"assets/Joints-XCUJshJ1.js\":\"45c30d09aff7238c548b2479b97169b2c51856fce16b6d4c52b49a0c8059b916\",\"assets/Motions-BemDUpjT.js\":\"61d89fcd114cab654a6e009856524f4048625698fb5778a9a88e03c4ae0b8376\",\"assets/Motions-CxnOFEXi.css\":\"8469f628155c6a1a826a2877357a72e019e19b21b42a7ff3ae0a2bc7d31cb181\",\"assets/System-D35VuJFA.js\":\"ea05c5f0a50ea8f24476900d6b0ced9bb36a17201203e2faab7a2b4d232141b4\",\"assets/System-SSQAs_fl.css\":\"e5e9cd7510c631696a4b0af4175aac40b21d04d09de510075a17c4feddc94f7d\",\"assets/index-DQmbFqqe.js\":\"840bdf573af6f0fd52f53a795677db49ce12492ce85cc35cb7ba7c191d7716d3\",\"assets/index-DmsQZcft.css\":\"45845ee9f02c1569fe3fc8bc001bacf7e541337518e36b69c9ece31d2d68a32b\",\"assets/manage-M41321JN.js\":\"5446ae16b688ef50dff6db70827b6f232a832031cd6b690a066c8355ab2edf20\",\"assets/model-DHXowZ_C.css\":\"ec960a47eec173c0a883112abe447603ac0f4e9b3603cd472118936ad0120b59\",\"assets/model-tQxOBPYR.js\":\"b3d00604563282a3f2f73a37944402e5b05f2f3d6d9701f3ed75f9a25406e5d6\",\"assets/news-0bL7-iuI.js\":\"8cc54aa9661bfbfd8f005e23f5a20d07056d2222fc000755a9cafd1b988299d6\",\"assets/parts-CiVZn0lF.js\":\"5991f89ad6c8213001540f164699c16176ada184c1558ea9278b46debdfcf61b\",\"assets/saving-DbPjuOQb.js\":\"94d1a2e76767f7fdfe2e444b94c2326a340904bc4ede0b5445dbbf7236821d66\",\"assets/stage-Dh_LsVXa.js\":\"71efe65a7b6131ccf0d1c1c570fa99f231dad8945762ded7d2b5860348bacefa\",\"assets/stream-C2WMbNVq.js\":\"755f7a7d95352183214d36e3340754c14f6e869729c055087393677bf9e18ce6\",\"assets/uPlot-CnsZ1jie.css\":\"0fd9465202f6dfceac29e67c17e5ac9fb1b7ba7615c1bb08782391b791d9f1e0\",\"assets/uPlot.esm-BScb58at.js\":\"068506d72590b07d0e53e012ff1541813c52c09bded848b3f97fcd1d4b0fd3b2\",\"favicon.ico\":\"eb66fde2ce87c9f33228184353f8a8c7ff0517cd76eaf9d6a94759bbd7276be9\",\"icon-192.png\":\"df4dde7d57f1963226b36d9501a3b173c02eddc858bef226ae0176dbb4b7ee19\",\"icon-512.png\":\"6e797a05bab65afa3472b6a2bbc42b2f7a33115ab789fa2403c592655657e04d\",\"icon-maskable.png\":\"98caea4e0138a5272161323354bea3585ecac298ff8576823258aeddee01a45f\",\"icon.svg\":\"d12d71c61b9b10bf6b04ba84d91497c272291cd0830c21d5ca98ce2c771fabf2\",\"index.html\":\"08701e20945de7ffe40c9b3612d1bfe418dd5d4dcb9d5c3f612c7b8e758d791d\",\"page.webmanifest\":\"909a00587727949215a61974b50bfb8f15bda9c788e30bb4cdae5af19732dc86\"}");
/** What the page itself names: enough to say that the robot is away. */
const SHELL = JSON.parse("[\"index.html\",\"icon.svg\",\"icon-192.png\",\"page.webmanifest\",\"assets/index-DQmbFqqe.js\",\"assets/parts-CiVZn0lF.js\",\"assets/index-DmsQZcft.css\"]");
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
