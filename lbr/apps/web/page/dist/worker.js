// Keeps the page for a robot that is off or far: the files that it was built with, each checked by its digest, and nothing
// else. What the robot says is never kept. The build fills in the names.
const BUILD = "927eabdfb19f565f";
/** @type {Record<string, string>} */
const FILES = JSON.parse("{\"assets/Behaviours-CW6UGM9H.css\":\"f8ec05f55e6ffeb2c0ecf622c8f86b9bcd1e9fc4197c1fb4ed8135c322d9d1a4\",\"assets/Behaviours-CWXMzcx_.js\":\"8ce875d45cdd83ccc3be0b701ef7c4c9107230039f3fcf0eeb375ab0137a5490\",\"assets/Call-BH-FlvRt.css\":\"72c27a044611bd5e73568c62521730576fefce8c2a7bc35fb38ab268f89da215\",\"assets/Call-CRBfh5VJ.js\":\"68306743025f6afce850697f5e5deb7ceb93ee2e5e1fe832714a399c97629ffd\",\"assets/Display-Dep6lcwJ.js\":\"e71fcbe57a411345efb313cdbf0f950181528f9709f0f9c0f692bac34720e153\",\"assets/Display-hbDRwTTd.css\":\"c83eeecb550859a06b9cd577a58e8c226d9ef24d37e0f7fb05ec1f901b52e67e\",\"assets/Drive-CACdsb0K.js\":\"4f7f91dc15c605265b0624a01d3ec8714ea0382fa3b42bc92398a640b2d3b4f1\",\"assets/Drive-YaSFFbqN.css\":\"89ff89c9ff3e8cdba41b473b9652b284ca486a91ce13e15bb88f32a32e0146c0\",\"assets/Joints-CuwVdHbR.js\":\"47a28a77f94acde075d6288d77d73868bfc560a2ceab8412cea30947c62e0275\",\"assets/Lacking-CacvYTQJ.css\":\"c7c4f4a3d3af03716a518f6da6ec94b34d1ffc67385869d3316d0f32ce4ddef3\",\"assets/Lacking-DThjwlae.js\":\"d0f7ce1d839bc62aad013e87debdcdf552b759531986887ba51c28b877798be6\",\"assets/Log-HtF1Oxp3.js\":\"ffbc0c7e04b97f4f9b301d79a8bff47aca74e95f36d98ce80d0b1d6d76f62857\",\"assets/Motions-CjopR8jm.css\":\"f2dbefb712dec8d10730c54e2d9f27031746dab5cbd6f90c4809dab64658ee20\",\"assets/Motions-OFnAt7qA.js\":\"d2f30afda608372214f452cc80234b87b706611124bab2aaa6f93fc7adc24866\",\"assets/System-BwV0DGHd.js\":\"170033b28b7d7d3a64c25b4fbb486c85ca4bae842379db8b004a11dee08f4cf5\",\"assets/System-Byz79CXU.css\":\"b09219fcd4932b983e1310e1c6efa4b5cb28b8977085ba9db51545cd4203bf3a\",\"assets/access-LI_SyaC_.js\":\"1fae46d2901adf379c2959ce4f7b0b23aa5d6beb9e03d1185b7633618c805dd4\",\"assets/connection-CrpBnHAA.js\":\"575985cadb1788e20ecdb7c0bfd961a076cf75c6173bd00bda2e0af899a5a375\",\"assets/index-DdE-lXmz.js\":\"b39fb076c231c329cda1be75b64c51bd98eada0c31f5a44bdf95baea214dfd66\",\"assets/index-rgPNC9JQ.css\":\"6e987d1248cd631b44fec0b2c75cfec3cf0bbffa5a8c100e09ed122d764986fb\",\"assets/manage-DxdmOqWe.js\":\"a551ec39f97419f5c87e2d95f437ab695845bb99227c8461e92de589aa91286f\",\"assets/model-CR0ILv50.js\":\"84e1b75e2fca53dc5c648e0959d7c14f4f3c5ddfafdd9d65114b3732ecb48257\",\"assets/model-wURZCf0a.css\":\"9aaf4c44fdf51be20099e29c6aa4d693e0d571c2935a9cf9327a5ee7dae909e6\",\"assets/news-B7TcVNI4.js\":\"e9c9a226f2a5e51fdfc3307c8d7381ecc5a151b4ea5c3f17e35dabe7d72dc451\",\"assets/parts-Bjauwus7.js\":\"3a7a1a230aa2bdb658759563af920c5c8fe50fc0ddc3866d2d681ac98c4badef\",\"assets/saving-DbPjuOQb.js\":\"94d1a2e76767f7fdfe2e444b94c2326a340904bc4ede0b5445dbbf7236821d66\",\"assets/stage-BRA3LLt4.js\":\"732c91448d0eab3f3161f19f1584d932a0fc2996d917c58bb4ca34cf97d0e5fd\",\"assets/stream-AHL8zEC0.js\":\"2d1914c4bf06b058acda2ddf468a9862d9c488fdb870d4532a25a7fa93c14c6c\",\"assets/uPlot-CnsZ1jie.css\":\"0fd9465202f6dfceac29e67c17e5ac9fb1b7ba7615c1bb08782391b791d9f1e0\",\"assets/uPlot.esm-BScb58at.js\":\"068506d72590b07d0e53e012ff1541813c52c09bded848b3f97fcd1d4b0fd3b2\",\"favicon.ico\":\"eb66fde2ce87c9f33228184353f8a8c7ff0517cd76eaf9d6a94759bbd7276be9\",\"icon-192.png\":\"df4dde7d57f1963226b36d9501a3b173c02eddc858bef226ae0176dbb4b7ee19\",\"icon-512.png\":\"6e797a05bab65afa3472b6a2bbc42b2f7a33115ab789fa2403c592655657e04d\",\"icon-maskable.png\":\"98caea4e0138a5272161323354bea3585ecac298ff8576823258aeddee01a45f\",\"icon.svg\":\"d12d71c61b9b10bf6b04ba84d91497c272291cd0830c21d5ca98ce2c771fabf2\",\"index.html\":\"5ec1258a955ed16dce58ca59cf6d10103a3bfd11edef7007dac3e8f9fa4e8912\",\"page.webmanifest\":\"909a00587727949215a61974b50bfb8f15bda9c788e30bb4cdae5af19732dc86\"}");
/** What the page itself names: enough to say that the robot is away. */
const SHELL = JSON.parse("[\"index.html\",\"icon.svg\",\"icon-192.png\",\"page.webmanifest\",\"assets/index-DdE-lXmz.js\",\"assets/access-LI_SyaC_.js\",\"assets/parts-Bjauwus7.js\",\"assets/index-rgPNC9JQ.css\"]");
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
