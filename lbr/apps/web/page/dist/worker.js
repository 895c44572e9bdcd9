// Keeps the page for a robot that is off or far: the files that it was built with, each checked by its digest, and nothing
// else. What the robot says is never kept. The build fills in the names.
const BUILD = "8b570c4e783248b5";
/** @type {Record<string, string>} */
const FILES = JSON.parse("{\"assets/Behaviours-Bd33Wnm7.js\":\"c8339901cff5b7caacd3016b0031daece7ea873cc044b545af22ee34b8e008a8\",\"assets/Behaviours-CW6UGM9H.css\":\"f8ec05f55e6ffeb2c0ecf622c8f86b9bcd1e9fc4197c1fb4ed8135c322d9d1a4\",\"assets/Call-BH-FlvRt.css\":\"72c27a044611bd5e73568c62521730576fefce8c2a7bc35fb38ab268f89da215\",\"assets/Call-C95bcNKG.js\":\"fc2a16c3811ef556cf090c53c5daf1f81ed88ab74edac86a290c70a29231567a\",\"assets/Display-CTdBd_Ft.js\":\"54873f0071a4d2a6ba3c22ec6c7f7ba4f84ec071235f5ebb06f2d042c843cd19\",\"assets/Display-hbDRwTTd.css\":\"c83eeecb550859a06b9cd577a58e8c226d9ef24d37e0f7fb05ec1f901b52e67e\",\"assets/Drive-CIzn5YtY.css\":\"33ac34cd8a6833763b364446a5c92d9c73372cbe12902189749570c614f3bd52\",\"assets/Drive-D4egy3Eo.js\":\"cde5f39c8896606cbdc937a76ab7e40c83e77955b6dd0daf264a5b27767c756d\",\"assets/Joints-CJTpIpCv.js\":\"4df6597dc808d95c1a8d9ad4ab6ef6a16b64c57deb22f50a9ca470fd8a60274f\",\"assets/Motions-BzIa5g46.js\":\"2d85ae59999e411eaac2e758818729b75451e510efad1e8e71923b86b820269f\",\"assets/Motions-DTmtowIs.css\":\"74f4e85481e71bfcd588edda731de4d747c10ec024662e83369e4c350bc0b733\",\"assets/System-DDx4SAUs.css\":\"3ee00a8d95ac92c760a3c7567de726908c8490d3599974ee01bd3177aea6c921\",\"assets/System-DXJUf2Tm.js\":\"6e1d2186c6af1cc0155614abb4d724a149fa00d292e5bf866bfe5218780d83ad\",\"assets/index-CqXgex_i.css\":\"8d0403160b41ab82f3daa20702698b6a1929373a93d233f1e421aa776a8bae0f\",\"assets/index-DGhEpW99.js\":\"9a42b16f97c110642c1ad886477c02b295685971231a08360fc2802fca606210\",\"assets/manage-DrbIbR46.js\":\"7bc7afccfbcc9d77a1d1c21880389f8124acc28018ec0407f777959689093097\",\"assets/model-Bx7yEgVu.css\":\"802b384b1a54f70974f60851ef6bb609817b19f6c569ccb15816cb9f8a7b4e9f\",\"assets/model-CX7ZqOio.js\":\"5d4ce6fef7a1fe86f87157397bd9309fa3e6967af29fafd2b12d496fb7678670\",\"assets/parts-C35-cgA8.js\":\"ed59812744bb5e79ef07ce51aa9a9757f1db89b80d106600867fd8d06bfea52b\",\"assets/saving-DbPjuOQb.js\":\"94d1a2e76767f7fdfe2e444b94c2326a340904bc4ede0b5445dbbf7236821d66\",\"assets/stage-ZrpgdN5v.js\":\"14b7144bb71c0565ea4c9922db102fdad7caa7a13f6780c7f2679fca7c582940\",\"assets/stream-B-SuTj_N.js\":\"846b99b3d40b36e2e307e2c05ae1d9b58c12fb8240dbf768e447ba741a67338a\",\"assets/uPlot-CnsZ1jie.css\":\"0fd9465202f6dfceac29e67c17e5ac9fb1b7ba7615c1bb08782391b791d9f1e0\",\"assets/uPlot.esm-BScb58at.js\":\"068506d72590b07d0e53e012ff1541813c52c09bded848b3f97fcd1d4b0fd3b2\",\"icon-192.png\":\"df4dde7d57f1963226b36d9501a3b173c02eddc858bef226ae0176dbb4b7ee19\",\"icon-512.png\":\"6e797a05bab65afa3472b6a2bbc42b2f7a33115ab789fa2403c592655657e04d\",\"icon-maskable.png\":\"98caea4e0138a5272161323354bea3585ecac298ff8576823258aeddee01a45f\",\"icon.svg\":\"d12d71c61b9b10bf6b04ba84d91497c272291cd0830c21d5ca98ce2c771fabf2\",\"index.html\":\"282fd86efe5c016db76a10f78e0bfee4e9e695b472e6729c6149dc92e4941ab3\",\"page.webmanifest\":\"909a00587727949215a61974b50bfb8f15bda9c788e30bb4cdae5af19732dc86\"}");
/** What the page itself names: enough to say that the robot is away. */
const SHELL = JSON.parse("[\"index.html\",\"icon.svg\",\"icon-192.png\",\"page.webmanifest\",\"assets/index-DGhEpW99.js\",\"assets/parts-C35-cgA8.js\",\"assets/index-CqXgex_i.css\"]");
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
