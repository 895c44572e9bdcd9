// Keeps the page for a robot that is off or far: the files that it was built with, each checked by its digest, and nothing
// else. What the robot says is never kept. The build fills in the names.
const BUILD = "2107a802557eb18a";
/** @type {Record<string, string>} */
const FILES = JSON.parse("{\"assets/Behaviours-CW6UGM9H.css\":\"f8ec05f55e6ffeb2c0ecf622c8f86b9bcd1e9fc4197c1fb4ed8135c322d9d1a4\",\"assets/Behaviours-DuXkO-B1.js\":\"3dde298f8ecbff64f7a456f57a6f600e77e23b4ac6a3f2f9efea4d0478ca101c\",\"assets/Call-BH-FlvRt.css\":\"72c27a044611bd5e73568c62521730576fefce8c2a7bc35fb38ab268f89da215\",\"assets/Call-Bkw9Fi6P.js\":\"4641d4c4ff5aee0a4b4c8133944f75ee1f52ba2c5e884d67135ecea32f5808b1\",\"assets/Display-CvaulFBj.js\":\"902c1cbcf918533327f12b75bd23514b672a00d2ed8de069dd5b9f1620c18751\",\"assets/Display-hbDRwTTd.css\":\"c83eeecb550859a06b9cd577a58e8c226d9ef24d37e0f7fb05ec1f901b52e67e\",\"assets/Drive-BliJB640.js\":\"1ca49f53ddba7257b81e734c8c3d92e1f1f987807999df8a0e9657ba443ce36b\",\"assets/Drive-YaSFFbqN.css\":\"89ff89c9ff3e8cdba41b473b9652b284ca486a91ce13e15bb88f32a32e0146c0\",\"assets/Joints-WhiQxhds.js\":\"bd863cb346ad96f2f68e53d32fe4ad154932305d0b0e95b13026ae8ba62e3cbb\",\"assets/Lacking-B1fd_P4_.js\":\"b068b77e72ca87f08bc4fd69e03132eac51e9c0d7d648755305693927c33d3cb\",\"assets/Lacking-CacvYTQJ.css\":\"c7c4f4a3d3af03716a518f6da6ec94b34d1ffc67385869d3316d0f32ce4ddef3\",\"assets/Log-pMLUL8ZQ.js\":\"b08e4b3bc5d0ffe324fe69bbc94867de4b32e66d1214eba461e04fa8ff1f8fa7\",\"assets/Motions-CjopR8jm.css\":\"f2dbefb712dec8d10730c54e2d9f27031746dab5cbd6f90c4809dab64658ee20\",\"assets/Motions-dAg4CY14.js\":\"105a4ac5e59792aea230b1429e46fad00f0f96e7c895d6c2cb4e78588fa9a5a7\",\"assets/System-Byz79CXU.css\":\"b09219fcd4932b983e1310e1c6efa4b5cb28b8977085ba9db51545cd4203bf3a\",\"assets/System-n3sZahLD.js\":\"9f6432d0f7bf0e87380603f604de18aac8cff7b949cded2d905d700b08d95251\",\"assets/access-CpicXpsp.js\":\"6bda86f728f4c89ed7957f993959e6059c8952619abc98bae1ab971d8b894d44\",\"assets/connection-C1CiJ7_c.js\":\"d35bb6cd8512cf1444fac67d9bc047cc12a8ec0ef0e587efceec9ee38d64d1f1\",\"assets/index-D-Bm8I60.js\":\"46ae802d15cadc6baff845a784667fe5961721a71809ec4a1e266a42c80290d0\",\"assets/index-rgPNC9JQ.css\":\"6e987d1248cd631b44fec0b2c75cfec3cf0bbffa5a8c100e09ed122d764986fb\",\"assets/manage-rawOgDp5.js\":\"abc6a1200643c7cb1263fc1f98a9c026e57b3c4e8fa5c8bc603058cee033467b\",\"assets/model-CaxJPiYz.js\":\"be7f4d05d298fdef7c47180f035179b94134cc1bce7cdf2ba21711db202dcf1b\",\"assets/model-wURZCf0a.css\":\"9aaf4c44fdf51be20099e29c6aa4d693e0d571c2935a9cf9327a5ee7dae909e6\",\"assets/news-B_klpVIN.js\":\"19391c15cad608aac537b22c80a23fbf619bce45ec3caac7b09be133b363fd8e\",\"assets/parts-DAjj2WZN.js\":\"f5bd4b362d39c99d3fcd8f32e554544b17ee457f2519944a9481bdf8dbbe0501\",\"assets/saving-DbPjuOQb.js\":\"94d1a2e76767f7fdfe2e444b94c2326a340904bc4ede0b5445dbbf7236821d66\",\"assets/stage-CUfCgNKf.js\":\"e5843e0bad4052138f5a03250499d4f1e972929048d99dcca2d3b68fbcb749fa\",\"assets/stream-wr-p_9CR.js\":\"3b850e50d3f4f83c966ec2d8f981b6a1806488109b2cef3a698c2cf26aeda2d1\",\"assets/uPlot-CnsZ1jie.css\":\"0fd9465202f6dfceac29e67c17e5ac9fb1b7ba7615c1bb08782391b791d9f1e0\",\"assets/uPlot.esm-BScb58at.js\":\"068506d72590b07d0e53e012ff1541813c52c09bded848b3f97fcd1d4b0fd3b2\",\"favicon.ico\":\"eb66fde2ce87c9f33228184353f8a8c7ff0517cd76eaf9d6a94759bbd7276be9\",\"icon-192.png\":\"df4dde7d57f1963226b36d9501a3b173c02eddc858bef226ae0176dbb4b7ee19\",\"icon-512.png\":\"6e797a05bab65afa3472b6a2bbc42b2f7a33115ab789fa2403c592655657e04d\",\"icon-maskable.png\":\"98caea4e0138a5272161323354bea3585ecac298ff8576823258aeddee01a45f\",\"icon.svg\":\"d12d71c61b9b10bf6b04ba84d91497c272291cd0830c21d5ca98ce2c771fabf2\",\"index.html\":\"d85ff8d24716638bc1e9fe1806dc5518d5460e0e90366562dc788478e6d6f7db\",\"page.webmanifest\":\"909a00587727949215a61974b50bfb8f15bda9c788e30bb4cdae5af19732dc86\"}");
/** What the page itself names: enough to say that the robot is away. */
const SHELL = JSON.parse("[\"index.html\",\"icon.svg\",\"icon-192.png\",\"page.webmanifest\",\"assets/index-D-Bm8I60.js\",\"assets/access-CpicXpsp.js\",\"assets/parts-DAjj2WZN.js\",\"assets/index-rgPNC9JQ.css\"]");
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
