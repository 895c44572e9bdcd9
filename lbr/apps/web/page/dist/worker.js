// Keeps the page for a robot that is off or far: the files that it was built with, each checked by its digest, and nothing
// else. What the robot says is never kept. The build fills in the names.
const BUILD = "f91913cc79d7f692";
/** @type {Record<string, string>} */
const FILES = JSON.parse("{\"assets/Behaviours-CW6UGM9H.css\":\"f8ec05f55e6ffeb2c0ecf622c8f86b9bcd1e9fc4197c1fb4ed8135c322d9d1a4\",\"assets/Behaviours-D-fAmhTL.js\":\"882082d1a0b4ea861b444d0de2fc4f3b0feb429ee08af8f5545f4dc60016aa65\",\"assets/Call-BH-FlvRt.css\":\"72c27a044611bd5e73568c62521730576fefce8c2a7bc35fb38ab268f89da215\",\"assets/Call-d448fwxf.js\":\"5f7a8ee7aef1df1cd2f646eef25ca5419aaedd2b1dbef03eba657fbc021c6b6b\",\"assets/Display-MDXAjlpe.js\":\"8cc2b0b98dbbf3f23aad8d1ec9e9c1104e432e08076e24fe10492cfc88184b0e\",\"assets/Display-hbDRwTTd.css\":\"c83eeecb550859a06b9cd577a58e8c226d9ef24d37e0f7fb05ec1f901b52e67e\",\"assets/Drive-BGc6YiCk.js\":\"4e899172c4393a0db8bf7ce81e67c474d0597ded6d81a7c2402560477c7375c2\",\"assets/Drive-YaSFFbqN.css\":\"89ff89c9ff3e8cdba41b473b9652b284ca486a91ce13e15bb88f32a32e0146c0\",\"assets/Joints-j4Zp10d1.js\":\"8fd25468daf0aaf72cf2d07625efcab9de6d219d4514dc7535a89f139fc837f8\",\"assets/Lacking-CacvYTQJ.css\":\"c7c4f4a3d3af03716a518f6da6ec94b34d1ffc67385869d3316d0f32ce4ddef3\",\"assets/Lacking-DzPXd9IY.js\":\"f2293371f5cb5134323832b6dbfa3cc5e30ae3a76b66033593c547a465acdbc6\",\"assets/Log-DJ_VziCM.js\":\"821202629bfa3888c45bd811b1e65de7f7c5ed50264315628f98e636155ec05f\",\"assets/Motions-5lZrNRXc.js\":\"dc4e64e1b7258b70d90d81a642801944bd6dc48fb4734806ad61e89ebe4774e2\",\"assets/Motions-CjopR8jm.css\":\"f2dbefb712dec8d10730c54e2d9f27031746dab5cbd6f90c4809dab64658ee20\",\"assets/System-Byz79CXU.css\":\"b09219fcd4932b983e1310e1c6efa4b5cb28b8977085ba9db51545cd4203bf3a\",\"assets/System-C5MV_aLu.js\":\"132af3cf46a847bba0729a4e168f39446981ec2aafcb3e8e6afd9b8560fba8e1\",\"assets/access-DKu_aJt-.js\":\"718f27469177975d1685e24e7a2fecf1d031183b187759501f5a49bc8f3cabc9\",\"assets/connection-B7ZJrDjX.js\":\"462a37bc8728d5cd09bfcddc0794da67106b4eefb18decf72ea3ffbd3106ecb5\",\"assets/index-CKUugx9v.js\":\"97ccc73d5c90526e89cb0e58f9496ec65bbb6a3d59caf72aeb8fb9af7aabb1b0\",\"assets/index-rgPNC9JQ.css\":\"6e987d1248cd631b44fec0b2c75cfec3cf0bbffa5a8c100e09ed122d764986fb\",\"assets/manage-BeOiPqPl.js\":\"4b46ea17dce261b61f2a86b51681fe5d5fce739ee4381850239fa0295026039c\",\"assets/model-Cm64aNSa.js\":\"1e78b6e549ec89199a872b0d6b6a046de9f9f81d968ef01833f2a6bb7b6bc5de\",\"assets/model-DOz-FssH.css\":\"e8d62533fea919b0cda585f16d36601c04251a398d49dc3c116086572e5a65ef\",\"assets/news-BPy8mZ5p.js\":\"30d33b3cc90dc5a8e061f855102e8416da6ba035e83d86589011ad80b125bb21\",\"assets/parts-BcqEoshh.js\":\"ec7fc6b0e6eb1b9e27d3895b6cc3466eb4bf5f32356d46059127a0c12180da4f\",\"assets/saving-DbPjuOQb.js\":\"94d1a2e76767f7fdfe2e444b94c2326a340904bc4ede0b5445dbbf7236821d66\",\"assets/stage-DBH6WLf_.js\":\"dbeb0e9f50ed52e843d378b46d8729478376e9bc704f999d5f8984cd304597fc\",\"assets/stream-9XFJLi3u.js\":\"c7a1bfa1de32ba20c5dfe5043eef149294b5edc35cc357b714e13769226c3b1f\",\"assets/uPlot-CnsZ1jie.css\":\"0fd9465202f6dfceac29e67c17e5ac9fb1b7ba7615c1bb08782391b791d9f1e0\",\"assets/uPlot.esm-BScb58at.js\":\"068506d72590b07d0e53e012ff1541813c52c09bded848b3f97fcd1d4b0fd3b2\",\"favicon.ico\":\"eb66fde2ce87c9f33228184353f8a8c7ff0517cd76eaf9d6a94759bbd7276be9\",\"icon-192.png\":\"df4dde7d57f1963226b36d9501a3b173c02eddc858bef226ae0176dbb4b7ee19\",\"icon-512.png\":\"6e797a05bab65afa3472b6a2bbc42b2f7a33115ab789fa2403c592655657e04d\",\"icon-maskable.png\":\"98caea4e0138a5272161323354bea3585ecac298ff8576823258aeddee01a45f\",\"icon.svg\":\"d12d71c61b9b10bf6b04ba84d91497c272291cd0830c21d5ca98ce2c771fabf2\",\"index.html\":\"ab1fd093e2144f15f823e9210a55fb530a9c4e94604391bf79f7a38abfd8c8b6\",\"page.webmanifest\":\"909a00587727949215a61974b50bfb8f15bda9c788e30bb4cdae5af19732dc86\"}");
/** What the page itself names: enough to say that the robot is away. */
const SHELL = JSON.parse("[\"index.html\",\"icon.svg\",\"icon-192.png\",\"page.webmanifest\",\"assets/index-CKUugx9v.js\",\"assets/access-DKu_aJt-.js\",\"assets/parts-BcqEoshh.js\",\"assets/index-rgPNC9JQ.css\"]");
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
