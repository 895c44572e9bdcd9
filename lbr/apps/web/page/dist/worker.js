// Keeps the page for a robot that is off or far: the files that it was built with, each checked by its digest, and nothing
// else. What the robot says is never kept. The build fills in the names.
const BUILD = "636b96d6e37ce56a";
/** @type {Record<string, string>} */
const FILES = JSON.parse("{\"assets/Behaviours-CW6UGM9H.css\":\"f8ec05f55e6ffeb2c0ecf622c8f86b9bcd1e9fc4197c1fb4ed8135c322d9d1a4\",\"assets/Behaviours-jO-QoM0V.js\":\"8f5258b111c9f3970ff5dd08752ab3c36e2211ee012d581321605decadb82c0a\",\"assets/Call-BH-FlvRt.css\":\"72c27a044611bd5e73568c62521730576fefce8c2a7bc35fb38ab268f89da215\",\"assets/Call-B_5AqAHH.js\":\"1159b6339ecf273b0004400b2fc2141c5cdff311a20a26038610ad5a7931a4ad\",\"assets/Display-CIqbgGqS.js\":\"ef449b4e25bb39449ad9e7d1929cfbd4c448261c2b8e38cc86b3d91548604ab0\",\"assets/Display-hbDRwTTd.css\":\"c83eeecb550859a06b9cd577a58e8c226d9ef24d37e0f7fb05ec1f901b52e67e\",\"assets/Drive-CGK_8BFa.css\":\"cb18b5ba8abd125241086a032af189bd5852d498211083e0d90f29ae6f21d0a4\",\"assets/Drive-L76xAWkr.js\":\"5a4ebbf293e2b9256501d7c3c5c3e1865dd70b30e99811a19dc678d17f28ec39\",\"assets/Joints-gPWx347i.js\":\"1e60d1cdcb5c93d997ba36e681ca6f12e86288b0725ac5c248b03d8ca065d9b9\",\"assets/Motions-CJ8u0cLY.js\":\"49535d880caab2092f57b171a7601604d0de285951c330e78c3f97644b69918a\",\"assets/Motions-DTmtowIs.css\":\"74f4e85481e71bfcd588edda731de4d747c10ec024662e83369e4c350bc0b733\",\"assets/System-C50BlGjt.js\":\"466d4e88d94f064de94fa8914ad2117bd5c6bbc7c4af6895a30bfa99fdd0170c\",\"assets/System-jqua0Vci.css\":\"13a941e38be03122f45e055548308ecda97084197d6ee1edd08c0c10920f3762\",\"assets/index-IhwbWSN0.css\":\"000fba70d15216a33a9dfa2c8ccc0a1ae9e2852bf0fd9a8981327438e3ba33e5\",\"assets/index-f91Vn1LF.js\":\"6c7592d98df3f2569202a86649dd066b40316baf0e8c673efb0122e75ff48e95\",\"assets/manage-DewZSJVE.js\":\"ec636297cea24a482c8b60717f697d9a2a0969e58a3f213db5bb17906464e2d2\",\"assets/model-BWEcPnNF.js\":\"19e6ae9aa9fee2d3dfb615df6fe4072b80c4294f22a62caf5dae4c116979093f\",\"assets/model-Bx7yEgVu.css\":\"802b384b1a54f70974f60851ef6bb609817b19f6c569ccb15816cb9f8a7b4e9f\",\"assets/parts-HPusfx7R.js\":\"2cdecc666c732e2cc8f81bb19f2cf749b564b4f206aa381e0cd6f8e71f82fbed\",\"assets/saving-DbPjuOQb.js\":\"94d1a2e76767f7fdfe2e444b94c2326a340904bc4ede0b5445dbbf7236821d66\",\"assets/stage-BoTbe6VX.js\":\"984aa262ef7db99cad4689103ffc8a273e4d65510521fb9897816c6e55d85b22\",\"assets/stream-D1uhr358.js\":\"e3d7bfc18d50c7ad4ecf1e2c5cea970823ec0cac4bd5bc232e6a34078e50c74a\",\"assets/uPlot-CnsZ1jie.css\":\"0fd9465202f6dfceac29e67c17e5ac9fb1b7ba7615c1bb08782391b791d9f1e0\",\"assets/uPlot.esm-BScb58at.js\":\"068506d72590b07d0e53e012ff1541813c52c09bded848b3f97fcd1d4b0fd3b2\",\"icon-192.png\":\"df4dde7d57f1963226b36d9501a3b173c02eddc858bef226ae0176dbb4b7ee19\",\"icon-512.png\":\"6e797a05bab65afa3472b6a2bbc42b2f7a33115ab789fa2403c592655657e04d\",\"icon-maskable.png\":\"98caea4e0138a5272161323354bea3585ecac298ff8576823258aeddee01a45f\",\"icon.svg\":\"d12d71c61b9b10bf6b04ba84d91497c272291cd0830c21d5ca98ce2c771fabf2\",\"index.html\":\"b351ac64f87fc76c2f8615473bd71850fed9dea854c9cd27ff6fe9bbe9080580\",\"page.webmanifest\":\"909a00587727949215a61974b50bfb8f15bda9c788e30bb4cdae5af19732dc86\"}");
/** What the page itself names: enough to say that the robot is away. */
const SHELL = JSON.parse("[\"index.html\",\"icon.svg\",\"icon-192.png\",\"page.webmanifest\",\"assets/index-f91Vn1LF.js\",\"assets/parts-HPusfx7R.js\",\"assets/index-IhwbWSN0.css\"]");
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
