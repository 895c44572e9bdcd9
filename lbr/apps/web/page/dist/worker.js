// Keeps the page for a robot that is off or far: the files that it was built with, each checked by its digest, and nothing
// else. What the robot says is never kept. The build fills in the names.
const BUILD = "c8a044c4950a8528";
/** @type {Record<string, string>} */
const FILES = JSON.parse("{\"assets/Behaviours-CW6UGM9H.css\":\"f8ec05f55e6ffeb2c0ecf622c8f86b9bcd1e9fc4197c1fb4ed8135c322d9d1a4\",\"assets/Behaviours-DlgWCRnZ.js\":\"edea394fef3457dd41578e965dfb018ca4be9f5fd9928f3c543090622fecb4ac\",\"assets/Call-BH-FlvRt.css\":\"72c27a044611bd5e73568c62521730576fefce8c2a7bc35fb38ab268f89da215\",\"assets/Call-DraVzmSn.js\":\"7ff34a97d4471b4e0cfb5aff58fac4aabff8e960fdd002584e2e1ad15885223a\",\"assets/Display-Btk0Y2YJ.js\":\"5bb3923e4dc847011ec136ef685e42330efedf860886e52e817615f72e3a8ad7\",\"assets/Display-hbDRwTTd.css\":\"c83eeecb550859a06b9cd577a58e8c226d9ef24d37e0f7fb05ec1f901b52e67e\",\"assets/Drive-BjeBiOfx.js\":\"dc75009d99a4cab2b2b47f158f3695ad00b49045fc1e1d167d944adac543d10b\",\"assets/Drive-YaSFFbqN.css\":\"89ff89c9ff3e8cdba41b473b9652b284ca486a91ce13e15bb88f32a32e0146c0\",\"assets/Joints-B1BB2RQp.js\":\"6a70c245b62a05a804a485a8ca87fc2e0343c13dbc2da30e604bead55eb49812\",\"assets/Lacking-CacvYTQJ.css\":\"c7c4f4a3d3af03716a518f6da6ec94b34d1ffc67385869d3316d0f32ce4ddef3\",\"assets/Lacking-De5x6HCf.js\":\"7b1a9ad8ed9b55911ab35df4b2623ce8d5b6d5280e4305c97dbfbfa9892e94b6\",\"assets/Log-BcB8UNsj.js\":\"73bca458c05b1fa864502fd29822222d11755888579ff39beb93553e5f634a9e\",\"assets/Motions-CCaGVTjj.js\":\"33a5c266bdf44ec30f255474812bf7bad627a7164a8a0c122b1c41281d86af99\",\"assets/Motions-CjopR8jm.css\":\"f2dbefb712dec8d10730c54e2d9f27031746dab5cbd6f90c4809dab64658ee20\",\"assets/System-BQmkx6UQ.js\":\"d688c240aa557fb0935c4a416d321c71c7d489679033b663855740a8c945e86d\",\"assets/System-Byz79CXU.css\":\"b09219fcd4932b983e1310e1c6efa4b5cb28b8977085ba9db51545cd4203bf3a\",\"assets/index-DzKUj5wj.js\":\"ee26cd57add6275ba403eeea5d532b44b6738fa4122444e3c4b952b86e66e993\",\"assets/index-rgPNC9JQ.css\":\"6e987d1248cd631b44fec0b2c75cfec3cf0bbffa5a8c100e09ed122d764986fb\",\"assets/manage-BINScqPS.js\":\"8f0965c0ced939c94eed8480b29ac4c8f103a907fcb9af398d75a7e6afbf32fa\",\"assets/model-DLhfIfAO.js\":\"b15c1cec63a2f3b1fba837e5b6ed5ab88b671ef3abc77261268296eb5c119af8\",\"assets/model-wURZCf0a.css\":\"9aaf4c44fdf51be20099e29c6aa4d693e0d571c2935a9cf9327a5ee7dae909e6\",\"assets/news-ByNmt1Bh.js\":\"21e958078295396c88b1f9801437f3686792231937af55f9c060cad4858da172\",\"assets/parts-CYQCkfKL.js\":\"24749a2378433a3758f39cfc0582851289fe181165d0ea888146bcb3ec93e0af\",\"assets/saving-DbPjuOQb.js\":\"94d1a2e76767f7fdfe2e444b94c2326a340904bc4ede0b5445dbbf7236821d66\",\"assets/stage-DBDslSHV.js\":\"0f0d0aa6fedbc856f8050eef349e2dc8dda3a0e560236f9648b9cd0e89b3a157\",\"assets/stream-Bo6qL__6.js\":\"02badddf9bd4c1e33cd768cc433bfdf19611bc1e23959ee58863a8f267d14b45\",\"assets/uPlot-CnsZ1jie.css\":\"0fd9465202f6dfceac29e67c17e5ac9fb1b7ba7615c1bb08782391b791d9f1e0\",\"assets/uPlot.esm-BScb58at.js\":\"068506d72590b07d0e53e012ff1541813c52c09bded848b3f97fcd1d4b0fd3b2\",\"favicon.ico\":\"eb66fde2ce87c9f33228184353f8a8c7ff0517cd76eaf9d6a94759bbd7276be9\",\"icon-192.png\":\"df4dde7d57f1963226b36d9501a3b173c02eddc858bef226ae0176dbb4b7ee19\",\"icon-512.png\":\"6e797a05bab65afa3472b6a2bbc42b2f7a33115ab789fa2403c592655657e04d\",\"icon-maskable.png\":\"98caea4e0138a5272161323354bea3585ecac298ff8576823258aeddee01a45f\",\"icon.svg\":\"d12d71c61b9b10bf6b04ba84d91497c272291cd0830c21d5ca98ce2c771fabf2\",\"index.html\":\"81584afd60d9c373721aeecb22857bc2d1b23ef7dac88848feeb0cfdf7908726\",\"page.webmanifest\":\"909a00587727949215a61974b50bfb8f15bda9c788e30bb4cdae5af19732dc86\"}");
/** What the page itself names: enough to say that the robot is away. */
const SHELL = JSON.parse("[\"index.html\",\"icon.svg\",\"icon-192.png\",\"page.webmanifest\",\"assets/index-DzKUj5wj.js\",\"assets/parts-CYQCkfKL.js\",\"assets/index-rgPNC9JQ.css\"]");
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
