// Keeps the page for a robot that is off or far: the files that it was built with, each checked by its digest, and nothing
// else. What the robot says is never kept. The build fills in the names.
const BUILD = "c08f6d5a7fce79b2";
/** @type {Record<string, string>} */
const FILES = JSON.parse("{\"assets/Behaviours-B1AVteBU.js\":\"2d17050b88c06b1368ad977c05331eaba524f94a04984d2eb87a6ccc8b5ec97f\",\"assets/Behaviours-CW6UGM9H.css\":\"f8ec05f55e6ffeb2c0ecf622c8f86b9bcd1e9fc4197c1fb4ed8135c322d9d1a4\",\"assets/Call-BH-FlvRt.css\":\"72c27a044611bd5e73568c62521730576fefce8c2a7bc35fb38ab268f89da215\",\"assets/Call-GRMa7Vum.js\":\"856010de4e1121b733cffe4c411a32548bd5a047cbd0df84b164e997f6cdeaf1\",\"assets/Display-Dxvg6SXV.js\":\"e64eb27c29daa6c1cb16ed4e540eecf52ee8f5851df469186082e5a23520bcac\",\"assets/Display-hbDRwTTd.css\":\"c83eeecb550859a06b9cd577a58e8c226d9ef24d37e0f7fb05ec1f901b52e67e\",\"assets/Drive-4osGqLV4.css\":\"068027e6e3fb156d06aa1ca17041a0e63f7ca8ffd7c579b59c58e6deb0f9802e\",\"assets/Drive-hd2Q4Lcq.js\":\"2c69fc0332ba55cf0bb736f1ec7f32ce92392d656b88e59310c5fda6c495cb96\",\"assets/Joints-wodMQJQs.js\":\"f3ea8dec9ca0e26d60374770de0258c4c9e00630ff2adfd8c5f5072b3f65a801\",\"assets/Motions-CxnOFEXi.css\":\"8469f628155c6a1a826a2877357a72e019e19b21b42a7ff3ae0a2bc7d31cb181\",\"assets/Motions-D3Lq1Zeg.js\":\"833f7e56ba64bd55228ad688efa873c9361440cbb4d221b1908ae01f15cfa115\",\"assets/System-C9LFfaww.js\":\"d39d6adb6eb2c0b4988ed287fd7fa06a9d32429ff93e3cfde0772ea178d8f5c9\",\"assets/System-D-VKYm84.css\":\"00770ab6c350eab1e1268a2e7b671bded9ea003dcbb92472b016dd805c05ad6e\",\"assets/index-C2gAbA-X.js\":\"36248cbdd43092df4d0ae7efc62918ba800d81a77b4afb100371dd247fc8da57\",\"assets/index-DmsQZcft.css\":\"45845ee9f02c1569fe3fc8bc001bacf7e541337518e36b69c9ece31d2d68a32b\",\"assets/manage-nyyLEFIj.js\":\"3fd58cfb679c722df463fc065e379f1cee8f7a584679e09d6764f9e80057ef0b\",\"assets/model-BpjlY-eZ.js\":\"02fe33b8ba2050cd121c53a05258dd068254f1912e0354889c0ae1b25c0c0a45\",\"assets/model-DHXowZ_C.css\":\"ec960a47eec173c0a883112abe447603ac0f4e9b3603cd472118936ad0120b59\",\"assets/news-mUBEG9YA.js\":\"83e5c01dfb16a4c710f56ae279f0df709362da868264204be07340f1e1dea822\",\"assets/parts-exFvLZwM.js\":\"8145979e0e367ddfe9fde19c07b1f417eca60388c431269770cc6802ae697d5c\",\"assets/saving-DbPjuOQb.js\":\"94d1a2e76767f7fdfe2e444b94c2326a340904bc4ede0b5445dbbf7236821d66\",\"assets/stage-Da6ZKiSD.js\":\"5911617b0bb4651433d579d3230b678ae46074efb14c70e75b340bfe8b61ca52\",\"assets/stream-DUspp5L4.js\":\"69e446116dc6e6d988d550ae53ace66c7dfeeabba151dbc6fb871e402faa6777\",\"assets/uPlot-CnsZ1jie.css\":\"0fd9465202f6dfceac29e67c17e5ac9fb1b7ba7615c1bb08782391b791d9f1e0\",\"assets/uPlot.esm-BScb58at.js\":\"068506d72590b07d0e53e012ff1541813c52c09bded848b3f97fcd1d4b0fd3b2\",\"favicon.ico\":\"eb66fde2ce87c9f33228184353f8a8c7ff0517cd76eaf9d6a94759bbd7276be9\",\"icon-192.png\":\"df4dde7d57f1963226b36d9501a3b173c02eddc858bef226ae0176dbb4b7ee19\",\"icon-512.png\":\"6e797a05bab65afa3472b6a2bbc42b2f7a33115ab789fa2403c592655657e04d\",\"icon-maskable.png\":\"98caea4e0138a5272161323354bea3585ecac298ff8576823258aeddee01a45f\",\"icon.svg\":\"d12d71c61b9b10bf6b04ba84d91497c272291cd0830c21d5ca98ce2c771fabf2\",\"index.html\":\"27181bdf47d25c6a0e83ec9aec1f00d5c0fdcf20aa52d6c82c0e94a194722c1e\",\"page.webmanifest\":\"909a00587727949215a61974b50bfb8f15bda9c788e30bb4cdae5af19732dc86\"}");
/** What the page itself names: enough to say that the robot is away. */
const SHELL = JSON.parse("[\"index.html\",\"icon.svg\",\"icon-192.png\",\"page.webmanifest\",\"assets/index-C2gAbA-X.js\",\"assets/parts-exFvLZwM.js\",\"assets/index-DmsQZcft.css\"]");
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
