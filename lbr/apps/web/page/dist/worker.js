// Keeps the page for a robot that is off or far: the files that it was built with, each checked by its digest, and nothing
// else. What the robot says is never kept. The build fills in the names.
const BUILD = "4bc12c07f6b17d6d";
/** @type {Record<string, string>} */
const FILES = JSON.parse("{\"assets/Behaviours-BiTgjzEM.js\":\"61195196a82d4c9661ebd335deb092d35272155617db43571d245bf7b0af6175\",\"assets/Behaviours-CW6UGM9H.css\":\"f8ec05f55e6ffeb2c0ecf622c8f86b9bcd1e9fc4197c1fb4ed8135c322d9d1a4\",\"assets/Call-BH-FlvRt.css\":\"72c27a044611bd5e73568c62521730576fefce8c2a7bc35fb38ab268f89da215\",\"assets/Call-Cq5qRxx_.js\":\"54c2883323919fa867d621a567bfebd6e0f43f7726af02f3640ba6e16a292167\",\"assets/Display-DdarwAlJ.js\":\"54c182069ff5783d5312d0ca0b3c8b9d56cf589ed2ed97918c469147f37c7472\",\"assets/Display-hbDRwTTd.css\":\"c83eeecb550859a06b9cd577a58e8c226d9ef24d37e0f7fb05ec1f901b52e67e\",\"assets/Drive-CIzn5YtY.css\":\"33ac34cd8a6833763b364446a5c92d9c73372cbe12902189749570c614f3bd52\",\"assets/Drive-evzfZSJ0.js\":\"6fb35898d42e75dfe456f6a5ae67b49808b2e0b63f1486a88260b8aa5653cf1b\",\"assets/Joints-DZQ5x3Tr.js\":\"7b315055388ab062c5fcb3a65c63b12c99f88ffe5bdc10c88dabb27d4b7f4818\",\"assets/Motions-DTmtowIs.css\":\"74f4e85481e71bfcd588edda731de4d747c10ec024662e83369e4c350bc0b733\",\"assets/Motions-xiS-68t9.js\":\"92646409ea9888aa6591e12e64cfcf434ffada72cf6226b4160597655d256560\",\"assets/System-BQlrWci1.js\":\"5e62ca427534ffbf02836857c0bf307215ed2ee244a83c48c78efeaa6358876d\",\"assets/System-Ch8fGQsc.css\":\"fe06b79534e407e0432e52ba5808c4cebb856c5ff634453639f100622e75b71f\",\"assets/index-BTldoJnH.css\":\"705b9d61c68f6a00568613cf60025a89f09b083ab251654d0ab527971b8b594e\",\"assets/index-CbVuiPDb.js\":\"bd79b20e1c6fa69458cebda4685c6751566ea6d80ca034f3a86a92af7cb4915d\",\"assets/manage-BDfO-mLt.js\":\"1bbac4a64417da23f60d62bb7b6542942bc1e705104a979f9970650c55a72d46\",\"assets/model-Bx7yEgVu.css\":\"802b384b1a54f70974f60851ef6bb609817b19f6c569ccb15816cb9f8a7b4e9f\",\"assets/model-jyRVqxVt.js\":\"761f31bcb994e58485069f11971383db52628b432232464e89176e9ed652897f\",\"assets/parts-CKv_QNrK.js\":\"67fadfd2cd7a23b6163c9dfff729093a6595a5a1ecfed47b0f709e4a42715bb2\",\"assets/saving-DbPjuOQb.js\":\"94d1a2e76767f7fdfe2e444b94c2326a340904bc4ede0b5445dbbf7236821d66\",\"assets/stage-DYrH3rxH.js\":\"df0cb437a0ffd3e608d3dca430bb1dbb35fd97f82dad4bec88b25f1e9abf798c\",\"assets/stream-C5H3D2-q.js\":\"6704fa7bb82fc0cfc98c0ccf502303b970691074ea03cc836b7ca95a0ca3614f\",\"assets/uPlot-CnsZ1jie.css\":\"0fd9465202f6dfceac29e67c17e5ac9fb1b7ba7615c1bb08782391b791d9f1e0\",\"assets/uPlot.esm-BScb58at.js\":\"068506d72590b07d0e53e012ff1541813c52c09bded848b3f97fcd1d4b0fd3b2\",\"icon-192.png\":\"df4dde7d57f1963226b36d9501a3b173c02eddc858bef226ae0176dbb4b7ee19\",\"icon-512.png\":\"6e797a05bab65afa3472b6a2bbc42b2f7a33115ab789fa2403c592655657e04d\",\"icon-maskable.png\":\"98caea4e0138a5272161323354bea3585ecac298ff8576823258aeddee01a45f\",\"icon.svg\":\"d12d71c61b9b10bf6b04ba84d91497c272291cd0830c21d5ca98ce2c771fabf2\",\"index.html\":\"99305a2c20fdceb4e42cadd115ecacd300b07deb811acb69d3e7f7b1f6aecd8e\",\"page.webmanifest\":\"909a00587727949215a61974b50bfb8f15bda9c788e30bb4cdae5af19732dc86\"}");
/** What the page itself names: enough to say that the robot is away. */
const SHELL = JSON.parse("[\"index.html\",\"icon.svg\",\"icon-192.png\",\"page.webmanifest\",\"assets/index-CbVuiPDb.js\",\"assets/parts-CKv_QNrK.js\",\"assets/index-BTldoJnH.css\"]");
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
