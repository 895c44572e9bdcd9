// Keeps the page for a robot that is off or far: the files that it was built with, each checked by its digest, and nothing
// else. What the robot says is never kept. The build fills in the names.
const BUILD = "92d476b38b6c8544";
/** @type {Record<string, string>} */
const FILES = JSON.parse("{\"assets/Behaviours-CW6UGM9H.css\":\"f8ec05f55e6ffeb2c0ecf622c8f86b9bcd1e9fc4197c1fb4ed8135c322d9d1a4\",\"assets/Behaviours-CXjg0Imb.js\":\"6f37d9345d3dffa2daa0a1216fcb02606242f88b99197be2966be59afd634426\",\"assets/Call-BH-FlvRt.css\":\"72c27a044611bd5e73568c62521730576fefce8c2a7bc35fb38ab268f89da215\",\"assets/Call-BdtfKdqU.js\":\"567daf9d0293f2cbdf603f643002d2b276b0fce73aef874b825a84ecaaef659c\",\"assets/Display-B-1JaG4u.js\":\"df1954e4bb5ea4865d33dbe7f4a8fb9ee205e443273baea6654b1981f1fa13f7\",\"assets/Display-hbDRwTTd.css\":\"c83eeecb550859a06b9cd577a58e8c226d9ef24d37e0f7fb05ec1f901b52e67e\",\"assets/Drive-CHb9XaeC.js\":\"9c93a4647f0fd7053eee54a96f88f8220c0e462172c0e4f7ad587d2f48faebde\",\"assets/Drive-CIzn5YtY.css\":\"33ac34cd8a6833763b364446a5c92d9c73372cbe12902189749570c614f3bd52\",\"assets/Joints-DSsevrJn.js\":\"7fcfcd4061f77b40fe8e1825a820d7177c3ebc437493b24ad9affb2db3e17261\",\"assets/Motions-CKyyZA4K.js\":\"7bb4c5bb140545c20348d86baee2fa9869f77722dd4ca79101443379f12b9c2c\",\"assets/Motions-DTmtowIs.css\":\"74f4e85481e71bfcd588edda731de4d747c10ec024662e83369e4c350bc0b733\",\"assets/System-C4481Hln.js\":\"ef5dd73674072902f3dc46a3eae5608ce7d9060b1d806a866b162b20958cf539\",\"assets/System-DDx4SAUs.css\":\"3ee00a8d95ac92c760a3c7567de726908c8490d3599974ee01bd3177aea6c921\",\"assets/index-B6dp6W7p.js\":\"b796ef71df3268ba525c259b59e07f8e00f83030e5f637d67130533892441d6f\",\"assets/index-CqXgex_i.css\":\"8d0403160b41ab82f3daa20702698b6a1929373a93d233f1e421aa776a8bae0f\",\"assets/manage-pqWNGVmO.js\":\"d8312e21dcad8fedce96226a1acfa2c1266326622a3a49554c66966f66545584\",\"assets/model-Bx7yEgVu.css\":\"802b384b1a54f70974f60851ef6bb609817b19f6c569ccb15816cb9f8a7b4e9f\",\"assets/model-NLbPVTJP.js\":\"febe4bbc39f81ff3740c9d0db07138658c234ae8256f0e9bce234d97c8fc0281\",\"assets/parts-CMw5jB0H.js\":\"7cea4dd8daaac59c434832aecdae8c5a17a1942bfe1c737b6cdf1e214c39ac23\",\"assets/saving-DbPjuOQb.js\":\"94d1a2e76767f7fdfe2e444b94c2326a340904bc4ede0b5445dbbf7236821d66\",\"assets/stage-bQ3_M_c5.js\":\"275d341010848961905db1ffaaea29c68e6bd6d50ab3b73366cf524464a34265\",\"assets/stream-CG_fphTA.js\":\"0baad1f4b10342b2a96988cb21c45957d8a3e2a9905b1d62df6d5df61f492366\",\"assets/uPlot-CnsZ1jie.css\":\"0fd9465202f6dfceac29e67c17e5ac9fb1b7ba7615c1bb08782391b791d9f1e0\",\"assets/uPlot.esm-BScb58at.js\":\"068506d72590b07d0e53e012ff1541813c52c09bded848b3f97fcd1d4b0fd3b2\",\"icon-192.png\":\"df4dde7d57f1963226b36d9501a3b173c02eddc858bef226ae0176dbb4b7ee19\",\"icon-512.png\":\"6e797a05bab65afa3472b6a2bbc42b2f7a33115ab789fa2403c592655657e04d\",\"icon-maskable.png\":\"98caea4e0138a5272161323354bea3585ecac298ff8576823258aeddee01a45f\",\"icon.svg\":\"d12d71c61b9b10bf6b04ba84d91497c272291cd0830c21d5ca98ce2c771fabf2\",\"index.html\":\"ffed5ac13e5decd3f5f592075193c2202336693583465b2d0c6dbef2c2408909\",\"page.webmanifest\":\"909a00587727949215a61974b50bfb8f15bda9c788e30bb4cdae5af19732dc86\"}");
/** What the page itself names: enough to say that the robot is away. */
const SHELL = JSON.parse("[\"index.html\",\"icon.svg\",\"icon-192.png\",\"page.webmanifest\",\"assets/index-B6dp6W7p.js\",\"assets/parts-CMw5jB0H.js\",\"assets/index-CqXgex_i.css\"]");
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
