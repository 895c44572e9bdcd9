// Keeps the page for a robot that is off or far: the files that it was built with, each checked by its digest, and nothing
// else. What the robot says is never kept. The build fills in the names.
const BUILD = "110a89661eeac500";
/** @type {Record<string, string>} */
const FILES = JSON.parse("{\"assets/Behaviours-CW6UGM9H.css\":\"f8ec05f55e6ffeb2c0ecf622c8f86b9bcd1e9fc4197c1fb4ed8135c322d9d1a4\",\"assets/Behaviours-b7V-Zurj.js\":\"e3397453b7618d9978be8685b10b2e114e3748f06a459dfd52bf8d665d8ef3cd\",\"assets/Call-BH-FlvRt.css\":\"72c27a044611bd5e73568c62521730576fefce8c2a7bc35fb38ab268f89da215\",\"assets/Call-C83KYthI.js\":\"e0186d462e93512d51be4b649f4840224237ad3a776952436c818610a957fbcc\",\"assets/Display-J4mZucnK.js\":\"01a4f973eec744005da4c09ae1cc841015c6d8fb03efd8174848fdc730db2e08\",\"assets/Display-hbDRwTTd.css\":\"c83eeecb550859a06b9cd577a58e8c226d9ef24d37e0f7fb05ec1f901b52e67e\",\"assets/Drive-CIzn5YtY.css\":\"33ac34cd8a6833763b364446a5c92d9c73372cbe12902189749570c614f3bd52\",\"assets/Drive-D0uVufwP.js\":\"e9ea578e2825c152927c688c4372123cdb96dc5a4a172947d83702cabff9f1d4\",\"assets/Joints-CbrFJmUk.js\":\"dc2a040acd8aa3400020e0498521bee3c1efbc87d59863ec6d79273bc7c68d74\",\"assets/Motions-BXYSpfrT.js\":\"4a8951135afd14aa35b1b797ceaba173b4a6c884020eebb1e1c51a3c903ac444\",\"assets/Motions-DTmtowIs.css\":\"74f4e85481e71bfcd588edda731de4d747c10ec024662e83369e4c350bc0b733\",\"assets/System-BkPbB3Ty.js\":\"394006e50fe3bfed0c2eb022fba66392125e6ed74e8651415ba8c12842a9eff9\",\"assets/System-Ch8fGQsc.css\":\"fe06b79534e407e0432e52ba5808c4cebb856c5ff634453639f100622e75b71f\",\"assets/index-BTldoJnH.css\":\"705b9d61c68f6a00568613cf60025a89f09b083ab251654d0ab527971b8b594e\",\"assets/index-CaspVU37.js\":\"835a6fc55c5c9b32cd6d0a317d2c65c1fa6cef93a21c8c7c34188f2d17236dd1\",\"assets/manage-hn2hlx-X.js\":\"5417a83f20016329335cfe68d3478efec2fc6c1e16e33f332c7c81fcaceb14f0\",\"assets/model-BWrYREeV.js\":\"98fdd43f6699065ccf321b1d54b7dc77c4610863fa09d139111d3242a796a435\",\"assets/model-Bx7yEgVu.css\":\"802b384b1a54f70974f60851ef6bb609817b19f6c569ccb15816cb9f8a7b4e9f\",\"assets/parts-ad_trsmF.js\":\"a5354bccd433bbae65ab25d53a482dd12991ce1348fe76776e2606669a47de11\",\"assets/saving-DbPjuOQb.js\":\"94d1a2e76767f7fdfe2e444b94c2326a340904bc4ede0b5445dbbf7236821d66\",\"assets/stage-CZeYDNUH.js\":\"2ba8a769779acaf82d0f04ebfa30c4d7a847147a5f3cb1686227dead221dfb8b\",\"assets/stream-C0w5hjby.js\":\"f5fcab6703532bf8f3770e36e926f18ede192729c528c9b090f0427c04ad70a5\",\"assets/uPlot-CnsZ1jie.css\":\"0fd9465202f6dfceac29e67c17e5ac9fb1b7ba7615c1bb08782391b791d9f1e0\",\"assets/uPlot.esm-BScb58at.js\":\"068506d72590b07d0e53e012ff1541813c52c09bded848b3f97fcd1d4b0fd3b2\",\"icon-192.png\":\"df4dde7d57f1963226b36d9501a3b173c02eddc858bef226ae0176dbb4b7ee19\",\"icon-512.png\":\"6e797a05bab65afa3472b6a2bbc42b2f7a33115ab789fa2403c592655657e04d\",\"icon-maskable.png\":\"98caea4e0138a5272161323354bea3585ecac298ff8576823258aeddee01a45f\",\"icon.svg\":\"d12d71c61b9b10bf6b04ba84d91497c272291cd0830c21d5ca98ce2c771fabf2\",\"index.html\":\"133a1afb9d33b3dc7263651f002ff5cf1f37a8f5503082b9bda9ae14d2476e1f\",\"page.webmanifest\":\"909a00587727949215a61974b50bfb8f15bda9c788e30bb4cdae5af19732dc86\"}");
/** What the page itself names: enough to say that the robot is away. */
const SHELL = JSON.parse("[\"index.html\",\"icon.svg\",\"icon-192.png\",\"page.webmanifest\",\"assets/index-CaspVU37.js\",\"assets/parts-ad_trsmF.js\",\"assets/index-BTldoJnH.css\"]");
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
