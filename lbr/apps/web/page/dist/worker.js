// Keeps the page for a robot that is off or far: the files that it was built with, each checked by its digest, and nothing
// else. What the robot says is never kept. The build fills in the names.
const BUILD = "d1f24fa7ef469c7f";
/** @type {Record<string, string>} */
const FILES = JSON.parse("{\"assets/Behaviours-BpHJbfwY.js\":\"4c3f464e371705d6abc18d3a16740eaf2169338e505aab529ea0a1c5e7e5b71a\",\"assets/Behaviours-CW6UGM9H.css\":\"f8ec05f55e6ffeb2c0ecf622c8f86b9bcd1e9fc4197c1fb4ed8135c322d9d1a4\",\"assets/Call-BH-FlvRt.css\":\"72c27a044611bd5e73568c62521730576fefce8c2a7bc35fb38ab268f89da215\",\"assets/Call-BZHjLovy.js\":\"16ffa07fa8c79421f20c32198068a0c0a5e09c73323c5594235a8a20416043f1\",\"assets/Display-BMolIsCl.js\":\"c37e9ea77b003019d3e4ed95060f03f0fae4390679e792f39f29e60b3974f638\",\"assets/Display-hbDRwTTd.css\":\"c83eeecb550859a06b9cd577a58e8c226d9ef24d37e0f7fb05ec1f901b52e67e\",\"assets/Drive-CiuoIAbs.css\":\"17805b96ada40ebf1ed073494d6679ba715eba850c1f7641880a94b0ba449301\",\"assets/Drive-lGLu7zc6.js\":\"d87716341301194f5584cdd36b6ac95228e4bcc694930d7d33c50d741e6fb103\",\"assets/Joints-wwYjvzfN.js\":\"73bbc129db0756002485cac62d09994bde038060cc9f430f55a980cd1a3810b4\",\"assets/Motions-DLZ2Q6yY.js\":\"43d9557c5440b7caa017b8f8876ef9df3268153acaf6be48c154ccfb054593f7\",\"assets/Motions-DTmtowIs.css\":\"74f4e85481e71bfcd588edda731de4d747c10ec024662e83369e4c350bc0b733\",\"assets/System-LBoWmSfy.css\":\"81d40e27a95ed5873e95cceac19d0642d1c6a3e0d3534fe12214d73b9daeb4b7\",\"assets/System-fIbHl_Vx.js\":\"8eb1275fc7931343fb6651de21a17f113371b440cbf07c0d9a986d7a7d789490\",\"assets/index-CsplOK0E.js\":\"be8549a3af1e2aeb12c3ff59d1464351b28f93723c8d0de000f6cb544b025502\",\"assets/index-IhwbWSN0.css\":\"000fba70d15216a33a9dfa2c8ccc0a1ae9e2852bf0fd9a8981327438e3ba33e5\",\"assets/manage-B_DudZio.js\":\"23baad88295c426bbfd19184635fbe1e87763412ac7b462e65604bf9f7399b72\",\"assets/model-Bx7yEgVu.css\":\"802b384b1a54f70974f60851ef6bb609817b19f6c569ccb15816cb9f8a7b4e9f\",\"assets/model-rfpe873M.js\":\"135487eea03a446ee0776376052d9b73f771b434554f231956ff091e6246c21e\",\"assets/parts-C4nCZ8_0.js\":\"badee4fa4f7e2d7c0b45dd10437ea645b3fdf2074ec8fd6e82cfcea5cbbd5124\",\"assets/saving-DbPjuOQb.js\":\"94d1a2e76767f7fdfe2e444b94c2326a340904bc4ede0b5445dbbf7236821d66\",\"assets/stage-B3U-sb_z.js\":\"2cce952469147c7a9d05af90f34476b68e3d9b3688d5363abe9316787139a9c9\",\"assets/stream-BXNWxUe7.js\":\"b289d835ef381b6062589d5f3463d584ff8456ed2a39adfd3912bdaaf3f62b50\",\"assets/uPlot-CnsZ1jie.css\":\"0fd9465202f6dfceac29e67c17e5ac9fb1b7ba7615c1bb08782391b791d9f1e0\",\"assets/uPlot.esm-BScb58at.js\":\"068506d72590b07d0e53e012ff1541813c52c09bded848b3f97fcd1d4b0fd3b2\",\"icon-192.png\":\"df4dde7d57f1963226b36d9501a3b173c02eddc858bef226ae0176dbb4b7ee19\",\"icon-512.png\":\"6e797a05bab65afa3472b6a2bbc42b2f7a33115ab789fa2403c592655657e04d\",\"icon-maskable.png\":\"98caea4e0138a5272161323354bea3585ecac298ff8576823258aeddee01a45f\",\"icon.svg\":\"d12d71c61b9b10bf6b04ba84d91497c272291cd0830c21d5ca98ce2c771fabf2\",\"index.html\":\"57afcf747664f7e510f00e684983e67e914631421d4f4ca59e74627756764b63\",\"page.webmanifest\":\"909a00587727949215a61974b50bfb8f15bda9c788e30bb4cdae5af19732dc86\"}");
/** What the page itself names: enough to say that the robot is away. */
const SHELL = JSON.parse("[\"index.html\",\"icon.svg\",\"icon-192.png\",\"page.webmanifest\",\"assets/index-CsplOK0E.js\",\"assets/parts-C4nCZ8_0.js\",\"assets/index-IhwbWSN0.css\"]");
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
