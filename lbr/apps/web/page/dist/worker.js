// Keeps the page for a robot that is off or far: the files that it was built with, each checked by its digest, and nothing
// else. What the robot says is never kept. The build fills in the names.
const BUILD = "76dc420d020b01ba";
/** @type {Record<string, string>} */
const FILES = JSON.parse("{\"assets/Behaviours-C3rRBthf.js\":\"071fd0362d4eff9e2c56168fb60ab7a036fccc3a237436577ea26c4ee117a64e\",\"assets/Behaviours-CW6UGM9H.css\":\"f8ec05f55e6ffeb2c0ecf622c8f86b9bcd1e9fc4197c1fb4ed8135c322d9d1a4\",\"assets/Call-BH-FlvRt.css\":\"72c27a044611bd5e73568c62521730576fefce8c2a7bc35fb38ab268f89da215\",\"assets/Call-rs3fl-SV.js\":\"b8ce82cfdde67c9123087fa6cd98f7f457cf3868aa810c41935743c87630349a\",\"assets/Display-Dm29TJeH.js\":\"33738eea3e2d1d51839faf67e32b2fc4d05ff901b3087a7d5b528dbda1cc87c0\",\"assets/Display-hbDRwTTd.css\":\"c83eeecb550859a06b9cd577a58e8c226d9ef24d37e0f7fb05ec1f901b52e67e\",\"assets/Drive-CyiRtKlI.js\":\"ab2d36b446cb5a5fc6fc4115a436357e673ca04f3e01117a7e9f99a47a0185fa\",\"assets/Drive-Dn8U9ubT.css\":\"343561370078a2e21f41db78ad043c1ec0f0db8ff4fb70abeee241a051d6d477\",\"assets/Joints-CzsA8dnE.js\":\"a2146388486b4697e09c41ddac369cca3e52efd19847cda803c8a5693ab62819\",\"assets/Lacking-CacvYTQJ.css\":\"c7c4f4a3d3af03716a518f6da6ec94b34d1ffc67385869d3316d0f32ce4ddef3\",\"assets/Lacking-DILIjITY.js\":\"180893be5a4940b0822bb2d8f601e0f2d41ce8c6d9208b6dc21df6e6e5151cca\",\"assets/Log-DCfjOt3P.js\":\"f7772f3ed104b35b4b7aef4096f98b88b3fc469a147e44c843f424b0adf5941b\",\"assets/Motions-BifVZSus.js\":\"9278813379c514abea64c3a8049a05b1f44072cbc9b807e39afcfd2a3d48206b\",\"assets/Motions-CjopR8jm.css\":\"f2dbefb712dec8d10730c54e2d9f27031746dab5cbd6f90c4809dab64658ee20\",\"assets/System-Byz79CXU.css\":\"b09219fcd4932b983e1310e1c6efa4b5cb28b8977085ba9db51545cd4203bf3a\",\"assets/System-D5jyg5K6.js\":\"419d5d04b2581b9982248042b048d45beb55afa7fee3e3adb25dabfb1bda2d15\",\"assets/index-BzKHDJa8.css\":\"7d79eb5639777501736c8a6d416b60d5b2485739d4889b17a9098c41170b244c\",\"assets/index-ncW2g3Hj.js\":\"b3a49730f2472ae14e2263792ec99a76e3bc99a92786f45f00eebaff58455b5d\",\"assets/manage-Crkf3VzE.js\":\"a3654589a78ae27a1c944e8e8f2d039163ade83ae2627e3f91207949a37cba01\",\"assets/model-DHXowZ_C.css\":\"ec960a47eec173c0a883112abe447603ac0f4e9b3603cd472118936ad0120b59\",\"assets/model-HR6xyabF.js\":\"d25afc17199c6131f5708b5b9fb0822eaa0d30f7de66dd9ba628eed72b9cc51e\",\"assets/news-DYu14twt.js\":\"f54dceb88db38ec941e885c2beae0af5872e72e5e541498f7132abf47432c014\",\"assets/parts-C4FT1fBJ.js\":\"ebca7bd8e1f0fb4670f6f2e894be0c3bcfca33a1aa34e5c53ebc250f7fc639a9\",\"assets/saving-DbPjuOQb.js\":\"94d1a2e76767f7fdfe2e444b94c2326a340904bc4ede0b5445dbbf7236821d66\",\"assets/stage-dPa4ea3O.js\":\"3402b64310feeefd3a58f6678aaf5295e0e5280e3308a680b005402a6eb40d87\",\"assets/stream-Bnkvcnxd.js\":\"d36953edf64fb19ecec94079e3c0ad5ce28d816bc12a0052776981a6f11fe672\",\"assets/uPlot-CnsZ1jie.css\":\"0fd9465202f6dfceac29e67c17e5ac9fb1b7ba7615c1bb08782391b791d9f1e0\",\"assets/uPlot.esm-BScb58at.js\":\"068506d72590b07d0e53e012ff1541813c52c09bded848b3f97fcd1d4b0fd3b2\",\"favicon.ico\":\"eb66fde2ce87c9f33228184353f8a8c7ff0517cd76eaf9d6a94759bbd7276be9\",\"icon-192.png\":\"df4dde7d57f1963226b36d9501a3b173c02eddc858bef226ae0176dbb4b7ee19\",\"icon-512.png\":\"6e797a05bab65afa3472b6a2bbc42b2f7a33115ab789fa2403c592655657e04d\",\"icon-maskable.png\":\"98caea4e0138a5272161323354bea3585ecac298ff8576823258aeddee01a45f\",\"icon.svg\":\"d12d71c61b9b10bf6b04ba84d91497c272291cd0830c21d5ca98ce2c771fabf2\",\"index.html\":\"981b24f0973e0c39753484755e2517d16166e6c3d83a976625c89db9f92ccf22\",\"page.webmanifest\":\"909a00587727949215a61974b50bfb8f15bda9c788e30bb4cdae5af19732dc86\"}");
/** What the page itself names: enough to say that the robot is away. */
const SHELL = JSON.parse("[\"index.html\",\"icon.svg\",\"icon-192.png\",\"page.webmanifest\",\"assets/index-ncW2g3Hj.js\",\"assets/parts-C4FT1fBJ.js\",\"assets/index-BzKHDJa8.css\"]");
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
