// Keeps the page for a robot that is off or far: the files that it was built with, each checked by its digest, and nothing
// else. What the robot says is never kept. The build fills in the names.
const BUILD = "74bc26b90b3d84d2";
/** @type {Record<string, string>} */
const FILES = JSON.parse("{\"assets/Behaviours-BdY5uFot.js\":\"ba70dfb0c40d4861839493d20fc7d0586075a7e35d7bbb263b7040eb9a052dea\",\"assets/Behaviours-CW6UGM9H.css\":\"f8ec05f55e6ffeb2c0ecf622c8f86b9bcd1e9fc4197c1fb4ed8135c322d9d1a4\",\"assets/Call-BH-FlvRt.css\":\"72c27a044611bd5e73568c62521730576fefce8c2a7bc35fb38ab268f89da215\",\"assets/Call-CXwbbxoG.js\":\"a84f8f86f400891d8ac0e17c6d2c33997b26f9a21b3b3496321bb3d38790f49e\",\"assets/Display-BwHh4wj3.js\":\"3c1206ee87be846ceb671a74ad17e229649472c7259f6c8ffc5beca8c47d2e7a\",\"assets/Display-hbDRwTTd.css\":\"c83eeecb550859a06b9cd577a58e8c226d9ef24d37e0f7fb05ec1f901b52e67e\",\"assets/Drive-4osGqLV4.css\":\"068027e6e3fb156d06aa1ca17041a0e63f7ca8ffd7c579b59c58e6deb0f9802e\",\"assets/Drive-CMv4O6ep.js\":\"40c46b2b7aecc0fb97230e810c013bcf41c344293f4c51862e8b238c2fbb137a\",\"assets/Joints-BEOb2DQ-.js\":\"811f764300dc55459ee27390755f7cee5d50dffc95ea591d49d178e122710d4b\",\"assets/Motions-BBg7tYUV.js\":\"c1852e4c58135a34240192511e7b8d27f64367df3f954b09ceea31e863f01d8b\",\"assets/Motions-CxnOFEXi.css\":\"8469f628155c6a1a826a2877357a72e019e19b21b42a7ff3ae0a2bc7d31cb181\",\"assets/System-TlcC1Lno.js\":\"b1a167a85b8112551d04a04bfe51907197102159bdb1f6e8155d6e51cd7201f4\",\"assets/System-gpcbJBcY.css\":\"d390c332f9f7bdf249ddd3bd70f1d3c91379f2cf70d30299646002b705212d62\",\"assets/index-BafnFfLG.js\":\"5ddebc8454b37b3e8769abce27a0cef752710af50c55754ae12b5d3e25fcd7c0\",\"assets/index-DmsQZcft.css\":\"45845ee9f02c1569fe3fc8bc001bacf7e541337518e36b69c9ece31d2d68a32b\",\"assets/manage-CrNIVn4l.js\":\"e1e2fd24dcd6e4db70022b9a5dbe3b87e330bd2453e95e8103fd7d96613c0b4e\",\"assets/model-ByCXW2Ux.js\":\"10725765119632d31cde13ae9ed12bc5a62dc8745aaa2184fa7b20be4455ac74\",\"assets/model-DHXowZ_C.css\":\"ec960a47eec173c0a883112abe447603ac0f4e9b3603cd472118936ad0120b59\",\"assets/news-DdRv5Dxi.js\":\"4632c2673d4b194388c83d472bb6a672a1b07481ac91decc655e7412e83b88a4\",\"assets/parts-T86A_2vH.js\":\"11aeb7fcee036ce5a76513b826ace1f42d68e8898f35c3645eb4c29ecc4d1d1a\",\"assets/saving-DbPjuOQb.js\":\"94d1a2e76767f7fdfe2e444b94c2326a340904bc4ede0b5445dbbf7236821d66\",\"assets/stage-CcAoH555.js\":\"a96b8b4bb6192a52d8b0abc6c190c2bb0fad518522e5bb30d83560a9964e2f3d\",\"assets/stream-Dz0UOxaw.js\":\"7d13c9ea6eff6048ad308f782ff5698437aea5ff81b8363406f66fdf4b8a6cb2\",\"assets/uPlot-CnsZ1jie.css\":\"0fd9465202f6dfceac29e67c17e5ac9fb1b7ba7615c1bb08782391b791d9f1e0\",\"assets/uPlot.esm-BScb58at.js\":\"068506d72590b07d0e53e012ff1541813c52c09bded848b3f97fcd1d4b0fd3b2\",\"favicon.ico\":\"eb66fde2ce87c9f33228184353f8a8c7ff0517cd76eaf9d6a94759bbd7276be9\",\"icon-192.png\":\"df4dde7d57f1963226b36d9501a3b173c02eddc858bef226ae0176dbb4b7ee19\",\"icon-512.png\":\"6e797a05bab65afa3472b6a2bbc42b2f7a33115ab789fa2403c592655657e04d\",\"icon-maskable.png\":\"98caea4e0138a5272161323354bea3585ecac298ff8576823258aeddee01a45f\",\"icon.svg\":\"d12d71c61b9b10bf6b04ba84d91497c272291cd0830c21d5ca98ce2c771fabf2\",\"index.html\":\"0edbff078d8b82efb3bf7b800547193891f5d7eab326b25ae698730749ccc78c\",\"page.webmanifest\":\"909a00587727949215a61974b50bfb8f15bda9c788e30bb4cdae5af19732dc86\"}");
/** What the page itself names: enough to say that the robot is away. */
const SHELL = JSON.parse("[\"index.html\",\"icon.svg\",\"icon-192.png\",\"page.webmanifest\",\"assets/index-BafnFfLG.js\",\"assets/parts-T86A_2vH.js\",\"assets/index-DmsQZcft.css\"]");
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
