// Keeps the page for a robot that is off or far: the files that it was built with, each checked by its digest, and nothing
// else. What the robot says is never kept. The build fills in the names.
const BUILD = "6b9ae16c46715ba0";
/** @type {Record<string, string>} */
const FILES = JSON.parse("{\"assets/Behaviours-B5DmpCp1.js\":\"ad0b261de5b5f6a6c493cd4232a45d5b8c841e53c9b50f378389a0df9d3ad274\",\"assets/Behaviours-CW6UGM9H.css\":\"f8ec05f55e6ffeb2c0ecf622c8f86b9bcd1e9fc4197c1fb4ed8135c322d9d1a4\",\"assets/Call-8UuKYi2V.js\":\"4113c6696db2a1f44ecbfd1107fb074f312fa49c109e951771cf016025f1375c\",\"assets/Call-BH-FlvRt.css\":\"72c27a044611bd5e73568c62521730576fefce8c2a7bc35fb38ab268f89da215\",\"assets/Display-hbDRwTTd.css\":\"c83eeecb550859a06b9cd577a58e8c226d9ef24d37e0f7fb05ec1f901b52e67e\",\"assets/Display-sDCTUUfy.js\":\"33f6b0e4176bda5848e5a96c249277da2b6820c168ad4d404d3ebd84ce74e356\",\"assets/Drive-4osGqLV4.css\":\"068027e6e3fb156d06aa1ca17041a0e63f7ca8ffd7c579b59c58e6deb0f9802e\",\"assets/Drive-BSGU8pZD.js\":\"2fd473e57718ba6464f9b00efaae48f0f9ccdcbf27010276e3eb3c711e0b001d\",\"assets/Joints-iNUbMoKe.js\":\"b6b596dbe028b79dd48546c540ce6f0ba68d9d81877265e5b859203bd82bf555\",\"assets/Lacking-BrETt_rM.js\":\"fa2a1f43f5d234950822488f05a6435abeae74494f19cb56d77b7e1d22956620\",\"assets/Lacking-CacvYTQJ.css\":\"c7c4f4a3d3af03716a518f6da6ec94b34d1ffc67385869d3316d0f32ce4ddef3\",\"assets/Log-BLRAeZgC.js\":\"01937f7dade1e26e9430534f7e0a7c7189758f9b1c08da7eed0bf76297a15c3d\",\"assets/Motions-CxnOFEXi.css\":\"8469f628155c6a1a826a2877357a72e019e19b21b42a7ff3ae0a2bc7d31cb181\",\"assets/Motions-DQqT4c7K.js\":\"9a2e87ae6bc44147518ce7d58a00429df091901d65df69ab815b5347bb5edf76\",\"assets/System-Byz79CXU.css\":\"b09219fcd4932b983e1310e1c6efa4b5cb28b8977085ba9db51545cd4203bf3a\",\"assets/System-inS64AUh.js\":\"4d4266ce4097ff7669ee78232e78ef0239aac4fcb755161d3a9ffb9d473b8066\",\"assets/index-B5B0_fT8.js\":\"62b8e95061ca85527d6dc040bf54b8c876bfaccde81497622d2ac66c898c50bd\",\"assets/index-_KY3zcl1.css\":\"ee7fa8614f5a30836f9843d438181568cac59bc9dfa0c9f9f993620a76a79878\",\"assets/manage-D0c7xckE.js\":\"a4453eb7787d809c00b600e04b5c43e122c7900b08eb3a43a39fc8502e0e9812\",\"assets/model-DHXowZ_C.css\":\"ec960a47eec173c0a883112abe447603ac0f4e9b3603cd472118936ad0120b59\",\"assets/model-EhJnCBPG.js\":\"0fc18e92033a5eaa4064955c22beae3ce9b2620a640a0aa20a49b4329b40a4cf\",\"assets/news-CPtu12qB.js\":\"eb60ee8f357f1af5823d6869bb11214dd36a5909e0f3fca4770b43184dfbe3ee\",\"assets/parts-QkxI-k72.js\":\"c5d9fd8eaf20fa99ed73519d1eebb99bd82284b0615f47fd75948f4fe664f7af\",\"assets/saving-DbPjuOQb.js\":\"94d1a2e76767f7fdfe2e444b94c2326a340904bc4ede0b5445dbbf7236821d66\",\"assets/stage-DfbYMPbw.js\":\"ed196e3b0a7e9dc2458eb67ccebaa75c40e41d3f74d9f2fb5872c2faaddde3a5\",\"assets/stream-B31R7pYR.js\":\"bb6f31a3fe2cdc4c24a8e82ce1215842fcf127988f2ad24f56a495af85dbad11\",\"assets/uPlot-CnsZ1jie.css\":\"0fd9465202f6dfceac29e67c17e5ac9fb1b7ba7615c1bb08782391b791d9f1e0\",\"assets/uPlot.esm-BScb58at.js\":\"068506d72590b07d0e53e012ff1541813c52c09bded848b3f97fcd1d4b0fd3b2\",\"favicon.ico\":\"eb66fde2ce87c9f33228184353f8a8c7ff0517cd76eaf9d6a94759bbd7276be9\",\"icon-192.png\":\"df4dde7d57f1963226b36d9501a3b173c02eddc858bef226ae0176dbb4b7ee19\",\"icon-512.png\":\"6e797a05bab65afa3472b6a2bbc42b2f7a33115ab789fa2403c592655657e04d\",\"icon-maskable.png\":\"98caea4e0138a5272161323354bea3585ecac298ff8576823258aeddee01a45f\",\"icon.svg\":\"d12d71c61b9b10bf6b04ba84d91497c272291cd0830c21d5ca98ce2c771fabf2\",\"index.html\":\"e10215e562fa014c8b5688034b2cf36ebf355fe907b80287576308a4da1551ff\",\"page.webmanifest\":\"909a00587727949215a61974b50bfb8f15bda9c788e30bb4cdae5af19732dc86\"}");
/** What the page itself names: enough to say that the robot is away. */
const SHELL = JSON.parse("[\"index.html\",\"icon.svg\",\"icon-192.png\",\"page.webmanifest\",\"assets/index-B5B0_fT8.js\",\"assets/parts-QkxI-k72.js\",\"assets/index-_KY3zcl1.css\"]");
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
