// Keeps the page for a robot that is off or far: the files that it was built with, each checked by its digest, and nothing
// else. What the robot says is never kept. The build fills in the names.
const BUILD = "f97b1e4b52cb1849";
/** @type {Record<string, string>} */
const FILES = JSON.parse("{\"assets/Behaviours-CW6UGM9H.css\":\"f8ec05f55e6ffeb2c0ecf622c8f86b9bcd1e9fc4197c1fb4ed8135c322d9d1a4\",\"assets/Behaviours-DDc6cXeC.js\":\"15f4fd7a736eaf7e993f3170af826f36265623cba080335f5cc15a3b2aba277d\",\"assets/Call-BH-FlvRt.css\":\"72c27a044611bd5e73568c62521730576fefce8c2a7bc35fb38ab268f89da215\",\"assets/Call-CSMPwwCH.js\":\"e5cbfabcad584de0600e3ee7895289d1cb43a617aa829dc9264c38de038457ca\",\"assets/Display-CQhpTqjA.js\":\"aea22e82360edc3812d04adc907d487efa26733c65df9b71222b202a0f558984\",\"assets/Display-hbDRwTTd.css\":\"c83eeecb550859a06b9cd577a58e8c226d9ef24d37e0f7fb05ec1f901b52e67e\",\"assets/Drive-BPHsjUz5.js\":\"a6537a5a40eaf372648e6fc3a813d969765bde07d758e822b0e9a5ebf71bb777\",\"assets/Drive-CKW8S2yW.css\":\"0d5b4fe84dc5515204cdf5d18363861700415a7bb6d85b89bf32ce01ae32cb94\",\"assets/Joints-9e0tZgb3.js\":\"9ed3c00c3246fd2c5087412949642f2924c12618872b56860fa19f6e69d10fc9\",\"assets/Lacking-CacvYTQJ.css\":\"c7c4f4a3d3af03716a518f6da6ec94b34d1ffc67385869d3316d0f32ce4ddef3\",\"assets/Lacking-DswG4NP1.js\":\"952ab98652baba188c2fc1e5f4c19b80cbf5a9f2426a81b56c060bb5c4ef675f\",\"assets/Log-C2U1cUS_.js\":\"82515a9e105909e245ae58bd1793d841d78491648b3f2083b64c2e5922822458\",\"assets/Motions--EH2LRQb.js\":\"fc3aa8f14b75e7fc199baac61b1a239eb5c730476491eff404f1c200f8eb3cb0\",\"assets/Motions-CxnOFEXi.css\":\"8469f628155c6a1a826a2877357a72e019e19b21b42a7ff3ae0a2bc7d31cb181\",\"assets/System-Byz79CXU.css\":\"b09219fcd4932b983e1310e1c6efa4b5cb28b8977085ba9db51545cd4203bf3a\",\"assets/System-kOSK24Fd.js\":\"947ef414219705e4e91f50427741e75bc09032c787753ffaa761e27e7b4e82c8\",\"assets/index-BU32TUQD.js\":\"dd88d153410c627cacac0629b28afe5306c1f1c59f5226c25e5166a445c0708e\",\"assets/index-_KY3zcl1.css\":\"ee7fa8614f5a30836f9843d438181568cac59bc9dfa0c9f9f993620a76a79878\",\"assets/manage-vAPW03wq.js\":\"46e9dbf378f1b2507b888fc29d61dc2219d1ac1d7ac43f8c62135ffd088f3733\",\"assets/model-D704JM-Y.js\":\"67a1b176d2afc12e7a2e2eff86e3dac2696e6e4a57cac11ac0baa99b4590c940\",\"assets/model-DHXowZ_C.css\":\"ec960a47eec173c0a883112abe447603ac0f4e9b3603cd472118936ad0120b59\",\"assets/news-Bv0-QByQ.js\":\"2adce857a27f7eb7419d36479c4020faa6358dba2ce741b7e06ab58468661bc2\",\"assets/parts-BK2do_AA.js\":\"a94156558f5572cca14ec142cafe90f3591fc9605c0e00b9deed13bce5e6d1b3\",\"assets/saving-DbPjuOQb.js\":\"94d1a2e76767f7fdfe2e444b94c2326a340904bc4ede0b5445dbbf7236821d66\",\"assets/stage-B7eF1rmp.js\":\"9f7962b27d53da9e0927f40a10c7eac21d6f4dae7c594ef72e5dece03f4b7338\",\"assets/stream-TtwYMRAR.js\":\"b34e326f1e02cbbad323942694ebc9729b6ab89dfa261bd8adb6376f5cb79e6e\",\"assets/uPlot-CnsZ1jie.css\":\"0fd9465202f6dfceac29e67c17e5ac9fb1b7ba7615c1bb08782391b791d9f1e0\",\"assets/uPlot.esm-BScb58at.js\":\"068506d72590b07d0e53e012ff1541813c52c09bded848b3f97fcd1d4b0fd3b2\",\"favicon.ico\":\"eb66fde2ce87c9f33228184353f8a8c7ff0517cd76eaf9d6a94759bbd7276be9\",\"icon-192.png\":\"df4dde7d57f1963226b36d9501a3b173c02eddc858bef226ae0176dbb4b7ee19\",\"icon-512.png\":\"6e797a05bab65afa3472b6a2bbc42b2f7a33115ab789fa2403c592655657e04d\",\"icon-maskable.png\":\"98caea4e0138a5272161323354bea3585ecac298ff8576823258aeddee01a45f\",\"icon.svg\":\"d12d71c61b9b10bf6b04ba84d91497c272291cd0830c21d5ca98ce2c771fabf2\",\"index.html\":\"9ae779d9231be2c766462bbbab0a88ac8f4e65396498ee0dac3c667dd6a4ddad\",\"page.webmanifest\":\"909a00587727949215a61974b50bfb8f15bda9c788e30bb4cdae5af19732dc86\"}");
/** What the page itself names: enough to say that the robot is away. */
const SHELL = JSON.parse("[\"index.html\",\"icon.svg\",\"icon-192.png\",\"page.webmanifest\",\"assets/index-BU32TUQD.js\",\"assets/parts-BK2do_AA.js\",\"assets/index-_KY3zcl1.css\"]");
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
