// Keeps the page for a robot that is off or far: the files that it was built with, each checked by its digest, and nothing
// else. What the robot says is never kept. The build fills in the names.
const BUILD = "26e458124108b5e2";
/** @type {Record<string, string>} */
const FILES = JSON.parse("{\"assets/Behaviours-CW6UGM9H.css\":\"f8ec05f55e6ffeb2c0ecf622c8f86b9bcd1e9fc4197c1fb4ed8135c322d9d1a4\",\"assets/Behaviours-TSzvtfrQ.js\":\"91b74fbc04c2286d371d42ba28a79e62dc89eeeeaf8e612e2af9b6a06435e407\",\"assets/Call-BH-FlvRt.css\":\"72c27a044611bd5e73568c62521730576fefce8c2a7bc35fb38ab268f89da215\",\"assets/Call-D5pj1CH_.js\":\"c2b4500bfc079dfc4b97c045f3b3a471bd6cfae808f58f3121efc70bd351dd1d\",\"assets/Display-BRibR8ck.js\":\"74585467bbf51b59adefcb1f8def74ba123b250d44d9123d5f3edf7bb7299e56\",\"assets/Display-hbDRwTTd.css\":\"c83eeecb550859a06b9cd577a58e8c226d9ef24d37e0f7fb05ec1f901b52e67e\",\"assets/Drive-DMeO12Yc.js\":\"6ec59c238e13d1db0124429d3e69cfe4f8438ad202db49ac185be65f2ab52b0b\",\"assets/Drive-YaSFFbqN.css\":\"89ff89c9ff3e8cdba41b473b9652b284ca486a91ce13e15bb88f32a32e0146c0\",\"assets/Joints-C6krDZo0.js\":\"b4d544aa5c0faca8b026d01ec4eaf225f78bcde0d3ef098f4b3510f2191b8ef0\",\"assets/Lacking-B8jIKorp.js\":\"0435e3b09cb1219cca8c083fce85e6ba605d3ee50297ffae1459e72687699650\",\"assets/Lacking-CacvYTQJ.css\":\"c7c4f4a3d3af03716a518f6da6ec94b34d1ffc67385869d3316d0f32ce4ddef3\",\"assets/Log-fm2PfIS9.js\":\"6b212b3f3a394f300cf6b9e06d977f5e2b0575f0f4d3d5f910866273ac6398db\",\"assets/Motions-CjopR8jm.css\":\"f2dbefb712dec8d10730c54e2d9f27031746dab5cbd6f90c4809dab64658ee20\",\"assets/Motions-DX6luMCz.js\":\"34e32bcef6ada3a3e5a3cfcbbc2dfe2891232115794462d7715ae6775846a509\",\"assets/System-BAhNeaK2.js\":\"a0ef2a56786f59985b48ef1e2a2045b3b88cd42d13c93527f5d2dbaeb8ab6070\",\"assets/System-Byz79CXU.css\":\"b09219fcd4932b983e1310e1c6efa4b5cb28b8977085ba9db51545cd4203bf3a\",\"assets/access-LI_SyaC_.js\":\"1fae46d2901adf379c2959ce4f7b0b23aa5d6beb9e03d1185b7633618c805dd4\",\"assets/connection-CrpBnHAA.js\":\"575985cadb1788e20ecdb7c0bfd961a076cf75c6173bd00bda2e0af899a5a375\",\"assets/index-COLPpz1u.js\":\"2ac70d0a6cf9ec9e371b9976da7c1ee4b9f9bfc7178a9a489703fccc94acb606\",\"assets/index-rgPNC9JQ.css\":\"6e987d1248cd631b44fec0b2c75cfec3cf0bbffa5a8c100e09ed122d764986fb\",\"assets/manage-CbUvaqrB.js\":\"39c01f554859183766bd7b94370bb4fcf1b508a019cc6df7c522788cf0ae9a0d\",\"assets/model-DOz-FssH.css\":\"e8d62533fea919b0cda585f16d36601c04251a398d49dc3c116086572e5a65ef\",\"assets/model-Dq2JlSw9.js\":\"b62951455bb1a0043bbacd3a16ae758ac3d571f9f396521a063bcf2fe75b4707\",\"assets/news-CM938lmx.js\":\"4a048a03238980fb6aecdb03f005375a99a8d98d4c82a002becb5ab59b4cc28f\",\"assets/parts-D34sTmJg.js\":\"0720288689db4a61f15b2d11a4d56d1eda8a49e28ba619d71ca61d042c8ee261\",\"assets/saving-DbPjuOQb.js\":\"94d1a2e76767f7fdfe2e444b94c2326a340904bc4ede0b5445dbbf7236821d66\",\"assets/stage-DFaRPfyW.js\":\"4a0a1b0d580877cdc3d7ac1bfaa26002316be7989d8b555dfb5f5cd77f32fd78\",\"assets/stream-CZoN6pmI.js\":\"5d31dd135cb20cac865579f3a4798991db924e92ed7dbfe5242dc4689db2d8cd\",\"assets/uPlot-CnsZ1jie.css\":\"0fd9465202f6dfceac29e67c17e5ac9fb1b7ba7615c1bb08782391b791d9f1e0\",\"assets/uPlot.esm-BScb58at.js\":\"068506d72590b07d0e53e012ff1541813c52c09bded848b3f97fcd1d4b0fd3b2\",\"favicon.ico\":\"eb66fde2ce87c9f33228184353f8a8c7ff0517cd76eaf9d6a94759bbd7276be9\",\"icon-192.png\":\"df4dde7d57f1963226b36d9501a3b173c02eddc858bef226ae0176dbb4b7ee19\",\"icon-512.png\":\"6e797a05bab65afa3472b6a2bbc42b2f7a33115ab789fa2403c592655657e04d\",\"icon-maskable.png\":\"98caea4e0138a5272161323354bea3585ecac298ff8576823258aeddee01a45f\",\"icon.svg\":\"d12d71c61b9b10bf6b04ba84d91497c272291cd0830c21d5ca98ce2c771fabf2\",\"index.html\":\"2dcc65ed43e37d6705e22ebd1c549fcf1e23136c4d85a835c4cd9a14297b28be\",\"page.webmanifest\":\"909a00587727949215a61974b50bfb8f15bda9c788e30bb4cdae5af19732dc86\"}");
/** What the page itself names: enough to say that the robot is away. */
const SHELL = JSON.parse("[\"index.html\",\"icon.svg\",\"icon-192.png\",\"page.webmanifest\",\"assets/index-COLPpz1u.js\",\"assets/access-LI_SyaC_.js\",\"assets/parts-D34sTmJg.js\",\"assets/index-rgPNC9JQ.css\"]");
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
