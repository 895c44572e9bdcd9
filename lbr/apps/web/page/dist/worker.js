// Keeps the page for a robot that is off or far: the files that it was built with, each checked by its digest, and nothing
// else. What the robot says is never kept. The build fills in the names.
const BUILD = "28a0abbbc4909b18";
/** @type {Record<string, string>} */
const FILES = JSON.parse("{\"assets/Behaviours-B-JavEPM.js\":\"c2bc7ad17cf57547ded539ed276e45dc966f5ddda5aafe01447b1bd9f1fe70f0\",\"assets/Behaviours-CW6UGM9H.css\":\"f8ec05f55e6ffeb2c0ecf622c8f86b9bcd1e9fc4197c1fb4ed8135c322d9d1a4\",\"assets/Call-BH-FlvRt.css\":\"72c27a044611bd5e73568c62521730576fefce8c2a7bc35fb38ab268f89da215\",\"assets/Call-ChzNEJ9E.js\":\"d51f1efd568acc53147a2472c3126adfc39219d8ec1e9e1d8b0a7803c1c9a873\",\"assets/Display-CMpqNJl2.js\":\"6da44c57ef9325be079eb189508c929c652982866dab1429d71bad03c04af643\",\"assets/Display-hbDRwTTd.css\":\"c83eeecb550859a06b9cd577a58e8c226d9ef24d37e0f7fb05ec1f901b52e67e\",\"assets/Drive-BFS_H-6F.js\":\"161a01bdc91cfbdf5a9449d53d0a1274a2071edc80aaadd9b3671afc30d9f1d8\",\"assets/Drive-CiuoIAbs.css\":\"17805b96ada40ebf1ed073494d6679ba715eba850c1f7641880a94b0ba449301\",\"assets/Joints-BzU2GztS.js\":\"aa0da58600d02886b87cf576466fcf336bb43763d7823cfed09fa743a34d8b51\",\"assets/Motions-D--Rz2xR.js\":\"3b3f957802d7e467eae419aaf79d8b481371a3587ae8a1ffa1e4df7926fcc56e\",\"assets/Motions-DTmtowIs.css\":\"74f4e85481e71bfcd588edda731de4d747c10ec024662e83369e4c350bc0b733\",\"assets/System-BYFgGjfB.js\":\"9bcca2f0824a64a6669e020e91c1c14268fe7ee20b51196415a4c6f126588604\",\"assets/System-jqua0Vci.css\":\"13a941e38be03122f45e055548308ecda97084197d6ee1edd08c0c10920f3762\",\"assets/index-DsqpIury.js\":\"b44d5fd6ea7079fb386a3962a3065303a7e8886977393611696195102053ba0a\",\"assets/index-IhwbWSN0.css\":\"000fba70d15216a33a9dfa2c8ccc0a1ae9e2852bf0fd9a8981327438e3ba33e5\",\"assets/manage-Dp86gVmd.js\":\"748a71f4e704568505e2e617b406cde865fb562dedda78d0e5b0ffceea8dd1ad\",\"assets/model-Bx7yEgVu.css\":\"802b384b1a54f70974f60851ef6bb609817b19f6c569ccb15816cb9f8a7b4e9f\",\"assets/model-NH0_IN_v.js\":\"8dcac5c3faa856f6138885ee4cfb9b5fbbdd5f30bfe101137001e78e6e3fb1c1\",\"assets/parts-CW4lI1MU.js\":\"b603bcd50471841e4bdb9bc982f6e074c878ed4d1587a37433298d8e8f8de441\",\"assets/saving-DbPjuOQb.js\":\"94d1a2e76767f7fdfe2e444b94c2326a340904bc4ede0b5445dbbf7236821d66\",\"assets/stage-egZMDlji.js\":\"4ede98bc0d87bccbd9063909482ba6aa75e7419dfb85a3a2eaec382eb1ca985a\",\"assets/stream-Cq0AQobd.js\":\"7622340e9d7251bce36401d1f2f9c3b88cfd34f2f0689e4bcd28f2af41226d24\",\"assets/uPlot-CnsZ1jie.css\":\"0fd9465202f6dfceac29e67c17e5ac9fb1b7ba7615c1bb08782391b791d9f1e0\",\"assets/uPlot.esm-BScb58at.js\":\"068506d72590b07d0e53e012ff1541813c52c09bded848b3f97fcd1d4b0fd3b2\",\"icon-192.png\":\"df4dde7d57f1963226b36d9501a3b173c02eddc858bef226ae0176dbb4b7ee19\",\"icon-512.png\":\"6e797a05bab65afa3472b6a2bbc42b2f7a33115ab789fa2403c592655657e04d\",\"icon-maskable.png\":\"98caea4e0138a5272161323354bea3585ecac298ff8576823258aeddee01a45f\",\"icon.svg\":\"d12d71c61b9b10bf6b04ba84d91497c272291cd0830c21d5ca98ce2c771fabf2\",\"index.html\":\"9056bb094d2de9332af3af3c1b57d1c8111e81c86c886502d5004c26e857ba00\",\"page.webmanifest\":\"909a00587727949215a61974b50bfb8f15bda9c788e30bb4cdae5af19732dc86\"}");
/** What the page itself names: enough to say that the robot is away. */
const SHELL = JSON.parse("[\"index.html\",\"icon.svg\",\"icon-192.png\",\"page.webmanifest\",\"assets/index-DsqpIury.js\",\"assets/parts-CW4lI1MU.js\",\"assets/index-IhwbWSN0.css\"]");
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
