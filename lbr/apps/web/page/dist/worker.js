// Keeps the page for a robot that is off or far: the files that it was built with, each checked by its digest, and nothing
// else. What the robot says is never kept. The build fills in the names.
const BUILD = "3bd67791bbf53887";
/** @type {Record<string, string>} */
const FILES = JSON.parse("{\"assets/Behaviours-Bsf_l1xY.js\":\"433a2e3c696d860ecca7a8aa342b981a32ad79fe1e6474772ef7302ec86366b3\",\"assets/Behaviours-CW6UGM9H.css\":\"f8ec05f55e6ffeb2c0ecf622c8f86b9bcd1e9fc4197c1fb4ed8135c322d9d1a4\",\"assets/Call-BH-FlvRt.css\":\"72c27a044611bd5e73568c62521730576fefce8c2a7bc35fb38ab268f89da215\",\"assets/Call-DRqdcB3l.js\":\"b43b89601e49df0e3a64307ead3d3b9dde02707f19233524c9a6293bdecbf082\",\"assets/Display-CzLVLS-J.js\":\"ba95d4fa955a5c556511830c57c52c0b802688c03f2e1da961e9a1c5d362eb91\",\"assets/Display-hbDRwTTd.css\":\"c83eeecb550859a06b9cd577a58e8c226d9ef24d37e0f7fb05ec1f901b52e67e\",\"assets/Drive-CiuoIAbs.css\":\"17805b96ada40ebf1ed073494d6679ba715eba850c1f7641880a94b0ba449301\",\"assets/Drive-CkGUB8sA.js\":\"4dc2ad447dc25b9d4d9d4bcfa1ba60dc56bcf54e2696a92cd7ecdc0cb81c0de8\",\"assets/Joints-DX6xSha5.js\":\"bb37cfad05a41c2068058befe9282db9dc0dd58574d1d6717ca4c641dccf1f97\",\"assets/Motions-DTmtowIs.css\":\"74f4e85481e71bfcd588edda731de4d747c10ec024662e83369e4c350bc0b733\",\"assets/Motions-pLxO1dBR.js\":\"c9002eecec3db532001c9605ac869197bc1518f7cc4d883cf6484bc4990efc0f\",\"assets/System-DEo79Rt6.js\":\"7af4a18f51d5644cd382428dcb7b68e489431bc0dfce66bc1b1027ccb49b0e05\",\"assets/System-LBoWmSfy.css\":\"81d40e27a95ed5873e95cceac19d0642d1c6a3e0d3534fe12214d73b9daeb4b7\",\"assets/index-BoJ_yzk1.js\":\"83fb5f2a738c0b0ad17996a8a744dc848d7f7f0d435ce3b9bf1ada211bda905d\",\"assets/index-IhwbWSN0.css\":\"000fba70d15216a33a9dfa2c8ccc0a1ae9e2852bf0fd9a8981327438e3ba33e5\",\"assets/manage-CNGb9F4d.js\":\"4ad893cba17646d00df73cc3dc03d0bb3d3f4ca05454e0f9f1502953a4d44499\",\"assets/model-BLgUxp5r.js\":\"30ffdf3689049c392d40bf0c6490b2be69fd056916d0b32f0d411fcce6eda644\",\"assets/model-Bx7yEgVu.css\":\"802b384b1a54f70974f60851ef6bb609817b19f6c569ccb15816cb9f8a7b4e9f\",\"assets/parts-CSxMLuer.js\":\"ff86132a33396da83cc34f01459897f6148f4ee4626ea365b532396a83b62fe0\",\"assets/saving-DbPjuOQb.js\":\"94d1a2e76767f7fdfe2e444b94c2326a340904bc4ede0b5445dbbf7236821d66\",\"assets/stage-DsxX9ujr.js\":\"22e084ef0d37a23bb4f13abffaaaa6387125b5b1970796bfeabeee6b43ebfa56\",\"assets/stream-D7f9SPhm.js\":\"219eeb6d7b2ebcaf1908242dd679cf38f395f2d5dbcc886620141aa8b8dfad53\",\"assets/uPlot-CnsZ1jie.css\":\"0fd9465202f6dfceac29e67c17e5ac9fb1b7ba7615c1bb08782391b791d9f1e0\",\"assets/uPlot.esm-BScb58at.js\":\"068506d72590b07d0e53e012ff1541813c52c09bded848b3f97fcd1d4b0fd3b2\",\"icon-192.png\":\"df4dde7d57f1963226b36d9501a3b173c02eddc858bef226ae0176dbb4b7ee19\",\"icon-512.png\":\"6e797a05bab65afa3472b6a2bbc42b2f7a33115ab789fa2403c592655657e04d\",\"icon-maskable.png\":\"98caea4e0138a5272161323354bea3585ecac298ff8576823258aeddee01a45f\",\"icon.svg\":\"d12d71c61b9b10bf6b04ba84d91497c272291cd0830c21d5ca98ce2c771fabf2\",\"index.html\":\"34631b0993e2ab8113ccdf8967857bd6c22d987f7c18d1376143e7c408e35dcd\",\"page.webmanifest\":\"909a00587727949215a61974b50bfb8f15bda9c788e30bb4cdae5af19732dc86\"}");
/** What the page itself names: enough to say that the robot is away. */
const SHELL = JSON.parse("[\"index.html\",\"icon.svg\",\"icon-192.png\",\"page.webmanifest\",\"assets/index-BoJ_yzk1.js\",\"assets/parts-CSxMLuer.js\",\"assets/index-IhwbWSN0.css\"]");
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
