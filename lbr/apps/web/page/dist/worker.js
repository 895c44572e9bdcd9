// Keeps the page for a robot that is off or far: the files that it was built with, each checked by its digest, and nothing
// else. What the robot says is never kept. The build fills in the names.
const BUILD = "6a8ea1b222368927";
/** @type {Record<string, string>} */
const FILES = JSON.parse("{\"assets/Behaviours-CMuMk4mU.js\":\"0804335673c23e6e7e9bf38bddb788047282a0d5e12971dde9fe76356a37a79a\",\"assets/Behaviours-CW6UGM9H.css\":\"f8ec05f55e6ffeb2c0ecf622c8f86b9bcd1e9fc4197c1fb4ed8135c322d9d1a4\",\"assets/Call-BH-FlvRt.css\":\"72c27a044611bd5e73568c62521730576fefce8c2a7bc35fb38ab268f89da215\",\"assets/Call-C3tXhzol.js\":\"05d4c565b959ad57dbb4aee47d0a5f99bc1ca9c95c77a1ac20a8c8560d8435f2\",\"assets/Display-hbDRwTTd.css\":\"c83eeecb550859a06b9cd577a58e8c226d9ef24d37e0f7fb05ec1f901b52e67e\",\"assets/Display-s6fEwPzE.js\":\"03193a1ec5e9e0b052c60da1a705ef62fd26b66176f9d9774f793e039393b927\",\"assets/Drive-CIzn5YtY.css\":\"33ac34cd8a6833763b364446a5c92d9c73372cbe12902189749570c614f3bd52\",\"assets/Drive-CKgpSrcX.js\":\"20104273ddf7fe39c5416596a656b32bd7ac33f5880d8495bb41ea302bf6667c\",\"assets/Joints-CBlgea18.js\":\"7a58dd4925ec3ea4021a35ff8b42c5b93fd42c296e0c165c391cc7a0dc741176\",\"assets/Motions-CRvE-D2J.js\":\"bcec6ad513039abdcb98a670904c2428c5e515645ded4c1583af312f249f1f23\",\"assets/Motions-DTmtowIs.css\":\"74f4e85481e71bfcd588edda731de4d747c10ec024662e83369e4c350bc0b733\",\"assets/System-Bujnd3dv.js\":\"8e621e6c35c878cbc51bb9658852abb18770863256bb743b21556eb6c95295d7\",\"assets/System-Ch8fGQsc.css\":\"fe06b79534e407e0432e52ba5808c4cebb856c5ff634453639f100622e75b71f\",\"assets/index-BNG1hLjN.js\":\"8cde532ad47eca7139d632a1d5e397cc2244681ad5327e15ed3977d475d47f60\",\"assets/index-BTldoJnH.css\":\"705b9d61c68f6a00568613cf60025a89f09b083ab251654d0ab527971b8b594e\",\"assets/manage-DMPxc-HZ.js\":\"15d3113abba3d63500ce6caf72d3551563f5fe23b739b9da0a3a36dc12be09f2\",\"assets/model-Bx7yEgVu.css\":\"802b384b1a54f70974f60851ef6bb609817b19f6c569ccb15816cb9f8a7b4e9f\",\"assets/model-LdkXmiHO.js\":\"d25c290868f91917d324d534ca26856ef182153322d26e0f31c3347be455fad2\",\"assets/parts-6skP1jjP.js\":\"07129bcd02bad7a00c6af1016cbfc37cf1b84f0e719b659e0e1501084fa2bf76\",\"assets/saving-DbPjuOQb.js\":\"94d1a2e76767f7fdfe2e444b94c2326a340904bc4ede0b5445dbbf7236821d66\",\"assets/stage-EVtRglt2.js\":\"4481a860ff07624451f19baf4adf35417a34e876a3f78daf2af51aeee424978d\",\"assets/stream-BLGIULX6.js\":\"f585af6bbc22ee541bd60152f4af08e26f33e8b15bde385c50fc5b3c97ae31ee\",\"assets/uPlot-CnsZ1jie.css\":\"0fd9465202f6dfceac29e67c17e5ac9fb1b7ba7615c1bb08782391b791d9f1e0\",\"assets/uPlot.esm-BScb58at.js\":\"068506d72590b07d0e53e012ff1541813c52c09bded848b3f97fcd1d4b0fd3b2\",\"icon-192.png\":\"df4dde7d57f1963226b36d9501a3b173c02eddc858bef226ae0176dbb4b7ee19\",\"icon-512.png\":\"6e797a05bab65afa3472b6a2bbc42b2f7a33115ab789fa2403c592655657e04d\",\"icon-maskable.png\":\"98caea4e0138a5272161323354bea3585ecac298ff8576823258aeddee01a45f\",\"icon.svg\":\"d12d71c61b9b10bf6b04ba84d91497c272291cd0830c21d5ca98ce2c771fabf2\",\"index.html\":\"051a4ca1046ddd547fbc18b83d330628b3f8a16f1ad36b5e92769f6d140c4ac3\",\"page.webmanifest\":\"909a00587727949215a61974b50bfb8f15bda9c788e30bb4cdae5af19732dc86\"}");
/** What the page itself names: enough to say that the robot is away. */
const SHELL = JSON.parse("[\"index.html\",\"icon.svg\",\"icon-192.png\",\"page.webmanifest\",\"assets/index-BNG1hLjN.js\",\"assets/parts-6skP1jjP.js\",\"assets/index-BTldoJnH.css\"]");
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
