// Keeps the page for a robot that is off or far: the files that it was built with, each checked by its digest, and nothing
// else. What the robot says is never kept. The build fills in the names.
const BUILD = "fef4301e6d06bf67";
/** @type {Record<string, string>} */
const FILES = JSON.parse("{\"assets/Behaviours-B1S8-tnd.js\":\"c6e73870132e3d4844cc6f9e899cca50ff267622d15d3bf85ad3b5c24cc76bb1\",\"assets/Behaviours-CW6UGM9H.css\":\"f8ec05f55e6ffeb2c0ecf622c8f86b9bcd1e9fc4197c1fb4ed8135c322d9d1a4\",\"assets/Call-BH-FlvRt.css\":\"72c27a044611bd5e73568c62521730576fefce8c2a7bc35fb38ab268f89da215\",\"assets/Call-Fuk6DK3e.js\":\"258ca08241674f00c0e925ac8f83a09af54465834164f79857f5c0a5d039ef70\",\"assets/Display-Bb66gN3T.js\":\"a4deb919399bc5b89d2aba9095365e2dfe5a72e55c03f9edbf349095cc23e313\",\"assets/Display-hbDRwTTd.css\":\"c83eeecb550859a06b9cd577a58e8c226d9ef24d37e0f7fb05ec1f901b52e67e\",\"assets/Drive-C8Tq45Zd.css\":\"08011867db62c8cb3b9c12a4042ef6bb9ec597d6a95f74b6b314a7d790941e10\",\"assets/Drive-D2nZD4ME.js\":\"70b8ad179ce6ea06e7eddcefd113c1e17d355ed5d5c6eb0c785f2f7585b63046\",\"assets/Joints-BKFbbfKr.js\":\"5ce6b360b1eb2ca81040c72b3b931f856d8f9ec825c2252c0a7ac4b1e4f86bea\",\"assets/Motions-24Cf6dUw.js\":\"ddc2c39e36a351a50f18657b8ed1a77a44d737a184da97804690751e6e05595a\",\"assets/Motions-CoUeG6QQ.css\":\"c7405ed80447ef97051d5de59d8b24ad9cce70b4956e89b2333a1e4c142f4c38\",\"assets/System-jfxpBu_o.js\":\"891a02a5b202756265ff4464a4b609a4451e402ef6045141f8b8da59ecd983a9\",\"assets/System-xJZzRxg6.css\":\"2d83ae9f9a033c027a167077f5d405b0a8a9e40b97a28f57c7d6949cb04c1462\",\"assets/index-CYk3GLvI.js\":\"ac4ff2f401ad4df1e479478d0d985c6c36d0adcc32a532b8f3c2d892cd598530\",\"assets/index-DIAhJi-2.css\":\"d0e765591aba08caf1fe52118718837f19e698789e9e691ba5b71b02e6cde5be\",\"assets/manage-Drk_oAay.js\":\"f0b1947bbfb938e00272226c1be6bf9be12357df58a829a5341359e410c4db80\",\"assets/model-Bx7yEgVu.css\":\"802b384b1a54f70974f60851ef6bb609817b19f6c569ccb15816cb9f8a7b4e9f\",\"assets/model-DpmnQDBE.js\":\"19cb48d055dd179f08d81c6fd19ccdb92af2b2b6187fc89ab194f18fc6234233\",\"assets/news-Cw2ydWM3.js\":\"3fc745e504e046ca6c76f412d60a01dd568c5bbc59375fd9d6181d7c48b21fed\",\"assets/parts-DhKJzix8.js\":\"2860f90065138aa46b40a56a065cc15237581f22efb645d4978ad5794978eb88\",\"assets/saving-DbPjuOQb.js\":\"94d1a2e76767f7fdfe2e444b94c2326a340904bc4ede0b5445dbbf7236821d66\",\"assets/stage-C8vHQmxu.js\":\"8c81b2525f553b9540ac222092ea65e5b2962123071627805ddf6e015dd8f4c1\",\"assets/stream-D-fDM6LO.js\":\"fc3e7db95efe679b6a5220dc1422dbaf38357737c0a52340cb7b1b9b519ae2b8\",\"assets/uPlot-CnsZ1jie.css\":\"0fd9465202f6dfceac29e67c17e5ac9fb1b7ba7615c1bb08782391b791d9f1e0\",\"assets/uPlot.esm-BScb58at.js\":\"068506d72590b07d0e53e012ff1541813c52c09bded848b3f97fcd1d4b0fd3b2\",\"icon-192.png\":\"df4dde7d57f1963226b36d9501a3b173c02eddc858bef226ae0176dbb4b7ee19\",\"icon-512.png\":\"6e797a05bab65afa3472b6a2bbc42b2f7a33115ab789fa2403c592655657e04d\",\"icon-maskable.png\":\"98caea4e0138a5272161323354bea3585ecac298ff8576823258aeddee01a45f\",\"icon.svg\":\"d12d71c61b9b10bf6b04ba84d91497c272291cd0830c21d5ca98ce2c771fabf2\",\"index.html\":\"37b1a4c980f5db386a29f5d08037069a349543e09fafa92dd0a5f7255fb39171\",\"page.webmanifest\":\"909a00587727949215a61974b50bfb8f15bda9c788e30bb4cdae5af19732dc86\"}");
/** What the page itself names: enough to say that the robot is away. */
const SHELL = JSON.parse("[\"index.html\",\"icon.svg\",\"icon-192.png\",\"page.webmanifest\",\"assets/index-CYk3GLvI.js\",\"assets/parts-DhKJzix8.js\",\"assets/index-DIAhJi-2.css\"]");
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
