// Keeps the page for a robot that is off or far: the files that it was built with, each checked by its digest, and nothing
// else. What the robot says is never kept. The build fills in the names.
const BUILD = "6cc19bf7fef211ba";
/** @type {Record<string, string>} */
const FILES = JSON.parse("{\"assets/Behaviours-CW6UGM9H.css\":\"f8ec05f55e6ffeb2c0ecf622c8f86b9bcd1e9fc4197c1fb4ed8135c322d9d1a4\",\"assets/Behaviours-DY7KSgtn.js\":\"e0b8790f79e8307b85cb818a91bb1db5b71ab31d5ce76e25c2c76f00880f5301\",\"assets/Call-BH-FlvRt.css\":\"72c27a044611bd5e73568c62521730576fefce8c2a7bc35fb38ab268f89da215\",\"assets/Call-DkykdGka.js\":\"60a60f7cd9fa77aabe42eff53f00e3250a54cf899fffdd76b4bc46c5fdcc9269\",\"assets/Display-CErkkdov.js\":\"8169e948666f9b666264988724b8cf5263ac60fe61694623c29459c195953239\",\"assets/Display-hbDRwTTd.css\":\"c83eeecb550859a06b9cd577a58e8c226d9ef24d37e0f7fb05ec1f901b52e67e\",\"assets/Drive-Cq3B0WYL.js\":\"1bdb468e668da0637d346016c0612f953f41ecd5b104bae61ff2ba598496f959\",\"assets/Drive-YaSFFbqN.css\":\"89ff89c9ff3e8cdba41b473b9652b284ca486a91ce13e15bb88f32a32e0146c0\",\"assets/Joints-lm60Pt-x.js\":\"ed1b9a2829043c64d0d24bff249ccf12004cb185ccdfbea7d8fa8c2b6f06dc72\",\"assets/Lacking-CacvYTQJ.css\":\"c7c4f4a3d3af03716a518f6da6ec94b34d1ffc67385869d3316d0f32ce4ddef3\",\"assets/Lacking-CeqwODiQ.js\":\"c54f06a983070e162fe53b57f3fd3e1ac5ef1b5e7d30d4cfc96f1fd2ec7690fd\",\"assets/Log-BWMph3yr.js\":\"9633ccc22463c6c40d79b1a2dfcd8ca80b56940a59dbadca8ab6b099c90a5f5a\",\"assets/Motions-CjopR8jm.css\":\"f2dbefb712dec8d10730c54e2d9f27031746dab5cbd6f90c4809dab64658ee20\",\"assets/Motions-DFwcIWdA.js\":\"fed787523895bdd6b6c815f7999faa5ecb25a163f6ac41ed9a268a92565a49db\",\"assets/System-Byz79CXU.css\":\"b09219fcd4932b983e1310e1c6efa4b5cb28b8977085ba9db51545cd4203bf3a\",\"assets/System-DooqH24j.js\":\"e4929104efba37106c0d8f3542bc36c012e49a29973a782e95a562bd6d339565\",\"assets/access-CUKqrLKC.js\":\"97929567094145fdeb44de73b719f6012917bf8b466e01e6f4dab6f8e3bdfbd7\",\"assets/connection-BTi9rNj9.js\":\"6e7f7139661057a9c9beca014d0e0d239f8965f40c3b42d42bf1b86a7faf42a0\",\"assets/index-lHPyUoCm.js\":\"fb6b948f0fb9e944d586582652a6bcaba9bbe256798872bbc6fba4c75f413263\",\"assets/index-rgPNC9JQ.css\":\"6e987d1248cd631b44fec0b2c75cfec3cf0bbffa5a8c100e09ed122d764986fb\",\"assets/manage-BBWj9CLX.js\":\"0e3bad719b779da6708ccf01a95c6801b646278752cf019a4449cd51edae9a83\",\"assets/model-COnn-ZVF.js\":\"7bfb801b9d2259b97cc5a6e97c29c2d11296e0713f94ce8e882536cf2c05e302\",\"assets/model-wURZCf0a.css\":\"9aaf4c44fdf51be20099e29c6aa4d693e0d571c2935a9cf9327a5ee7dae909e6\",\"assets/news-B27eNNPd.js\":\"962d5c1dd1003c44c8cdddcafded5b17cabcab3ac19934eee3caa9e27156deb3\",\"assets/parts-CwayNtA5.js\":\"9a9e68dbb68ec7067d5487fc9ffbb986121a24fc7456d01fd204ff736ea14250\",\"assets/saving-DbPjuOQb.js\":\"94d1a2e76767f7fdfe2e444b94c2326a340904bc4ede0b5445dbbf7236821d66\",\"assets/stage-B_ooLzMA.js\":\"be5248a2d3f91d23977b04f9014485f538da595490ac94d8ec367796e97d7fc1\",\"assets/stream-C8eY9nfj.js\":\"fc0bf071d7b86014714ad783d573b7add98380223983fd7aba31920d14215abc\",\"assets/uPlot-CnsZ1jie.css\":\"0fd9465202f6dfceac29e67c17e5ac9fb1b7ba7615c1bb08782391b791d9f1e0\",\"assets/uPlot.esm-BScb58at.js\":\"068506d72590b07d0e53e012ff1541813c52c09bded848b3f97fcd1d4b0fd3b2\",\"favicon.ico\":\"eb66fde2ce87c9f33228184353f8a8c7ff0517cd76eaf9d6a94759bbd7276be9\",\"icon-192.png\":\"df4dde7d57f1963226b36d9501a3b173c02eddc858bef226ae0176dbb4b7ee19\",\"icon-512.png\":\"6e797a05bab65afa3472b6a2bbc42b2f7a33115ab789fa2403c592655657e04d\",\"icon-maskable.png\":\"98caea4e0138a5272161323354bea3585ecac298ff8576823258aeddee01a45f\",\"icon.svg\":\"d12d71c61b9b10bf6b04ba84d91497c272291cd0830c21d5ca98ce2c771fabf2\",\"index.html\":\"39cdab45855e0d72261182d306a2491dbb579c400b89c18dc3c0cac2dad24703\",\"page.webmanifest\":\"909a00587727949215a61974b50bfb8f15bda9c788e30bb4cdae5af19732dc86\"}");
/** What the page itself names: enough to say that the robot is away. */
const SHELL = JSON.parse("[\"index.html\",\"icon.svg\",\"icon-192.png\",\"page.webmanifest\",\"assets/index-lHPyUoCm.js\",\"assets/access-CUKqrLKC.js\",\"assets/parts-CwayNtA5.js\",\"assets/index-rgPNC9JQ.css\"]");
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
