// Keeps the page for a robot that is off or far: the files that it was built with, each checked by its digest, and nothing
// else. What the robot says is never kept. The build fills in the names.
const BUILD = "71dde3048ec2efc2";
/** @type {Record<string, string>} */
const FILES = JSON.parse("{\"assets/Behaviours-CW6UGM9H.css\":\"f8ec05f55e6ffeb2c0ecf622c8f86b9bcd1e9fc4197c1fb4ed8135c322d9d1a4\",\"assets/Behaviours-Cjs_L9sB.js\":\"61456f492664ee5dbdd5e3f89cda3dbf37db9fb8391748ab70846edeb7d69d58\",\"assets/Call-BH-FlvRt.css\":\"72c27a044611bd5e73568c62521730576fefce8c2a7bc35fb38ab268f89da215\",\"assets/Call-Bqijwr0V.js\":\"429dda9ddc4d59fca136e6449b7750772d0dcbd0a628af1d0510280e78785bf6\",\"assets/Display-ChgJhpPw.js\":\"e23d56baf3e95010a9057a96a8631a15061c9b41d529650c7425f85d3bf3ffc4\",\"assets/Display-hbDRwTTd.css\":\"c83eeecb550859a06b9cd577a58e8c226d9ef24d37e0f7fb05ec1f901b52e67e\",\"assets/Drive-4osGqLV4.css\":\"068027e6e3fb156d06aa1ca17041a0e63f7ca8ffd7c579b59c58e6deb0f9802e\",\"assets/Drive-8gFKl7pG.js\":\"fbed398d6f0a3c77cadf9c87f8cad15de2f1f15c1395803f07e195d029a72254\",\"assets/Joints-DSnX31MX.js\":\"90c06f4fde829af231b2d5a670238eb5d9af5c8a0a1c1f6952c4c28e4b9ea4cd\",\"assets/Lacking-CacvYTQJ.css\":\"c7c4f4a3d3af03716a518f6da6ec94b34d1ffc67385869d3316d0f32ce4ddef3\",\"assets/Lacking-rcQhWUf3.js\":\"b790c76514ab6b1beab6404a88047cd72b8ac3ff253cdce3114d941086dad2ee\",\"assets/Log-BIZIoZKF.js\":\"24686a2bab23bfdec32395c7131abac61c69bd59b6d359d234a32b35f47c9bb2\",\"assets/Motions-CxnOFEXi.css\":\"8469f628155c6a1a826a2877357a72e019e19b21b42a7ff3ae0a2bc7d31cb181\",\"assets/Motions-DKC9iTUK.js\":\"d0c77b35baeff2e7e62196189925dccb4c72bd93bfe6767577b57207246b5b1a\",\"assets/System-Byz79CXU.css\":\"b09219fcd4932b983e1310e1c6efa4b5cb28b8977085ba9db51545cd4203bf3a\",\"assets/System-FHlbJxIa.js\":\"671c8c1df217eaad444572a6be43adfe20f76e769533184a33c35c9c79880cb9\",\"assets/index-_KY3zcl1.css\":\"ee7fa8614f5a30836f9843d438181568cac59bc9dfa0c9f9f993620a76a79878\",\"assets/index-kUM1EXQj.js\":\"24f80263cf89b939e556c25005ce657f78e76748aca1f5aca2963ebaaf3267af\",\"assets/manage-CPJy9I-4.js\":\"017b177d6b0fd474aa7acf111f828f5233256a12ab50066adb2aa77ea7b2ca18\",\"assets/model-DHXowZ_C.css\":\"ec960a47eec173c0a883112abe447603ac0f4e9b3603cd472118936ad0120b59\",\"assets/model-DawWA3ZF.js\":\"2ffad29184f60798ded12d8ee26bacb1e97d3a45e973b13dcf4d12cce157903b\",\"assets/news-CtoIMusl.js\":\"cfa9ddb591858fbe3130dfee5f483f9a53f93f64f7c8d73f95b48fd62988bd0b\",\"assets/parts-i-7eQLj8.js\":\"8a5fd1bbad62f190a44ab958306dc68ef8af1dd2205e78435a46bd00ee13eeca\",\"assets/saving-DbPjuOQb.js\":\"94d1a2e76767f7fdfe2e444b94c2326a340904bc4ede0b5445dbbf7236821d66\",\"assets/stage-C15k9o-Q.js\":\"f6bf0ff24d1fff056618af543552cd22dc4b81769f75630fbae67046ff8fd0e3\",\"assets/stream-BTRoclmM.js\":\"042734154909d416fac6ec183be45218ec46e69cfc1c574edbebd93861a552fe\",\"assets/uPlot-CnsZ1jie.css\":\"0fd9465202f6dfceac29e67c17e5ac9fb1b7ba7615c1bb08782391b791d9f1e0\",\"assets/uPlot.esm-BScb58at.js\":\"068506d72590b07d0e53e012ff1541813c52c09bded848b3f97fcd1d4b0fd3b2\",\"favicon.ico\":\"eb66fde2ce87c9f33228184353f8a8c7ff0517cd76eaf9d6a94759bbd7276be9\",\"icon-192.png\":\"df4dde7d57f1963226b36d9501a3b173c02eddc858bef226ae0176dbb4b7ee19\",\"icon-512.png\":\"6e797a05bab65afa3472b6a2bbc42b2f7a33115ab789fa2403c592655657e04d\",\"icon-maskable.png\":\"98caea4e0138a5272161323354bea3585ecac298ff8576823258aeddee01a45f\",\"icon.svg\":\"d12d71c61b9b10bf6b04ba84d91497c272291cd0830c21d5ca98ce2c771fabf2\",\"index.html\":\"8f1fd638dae2a70cfdcf74ac946476747fcf63d099b4826f02abed7d3c0440ab\",\"page.webmanifest\":\"909a00587727949215a61974b50bfb8f15bda9c788e30bb4cdae5af19732dc86\"}");
/** What the page itself names: enough to say that the robot is away. */
const SHELL = JSON.parse("[\"index.html\",\"icon.svg\",\"icon-192.png\",\"page.webmanifest\",\"assets/index-kUM1EXQj.js\",\"assets/parts-i-7eQLj8.js\",\"assets/index-_KY3zcl1.css\"]");
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
