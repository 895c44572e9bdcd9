// Keeps the page for a robot that is off or far: the files that it was built with, each checked by its digest, and nothing
// else. What the robot says is never kept. The build fills in the names.
const BUILD = "6602a1ff907ef786";
/** @type {Record<string, string>} */
const FILES = JSON.parse("{\"assets/Behaviours-BW6K-Nl5.js\":\"b76e7a94b67cdb0ad82c2814cbc5a8f66361c77eb2017850e65279dd1088d842\",\"assets/Behaviours-CW6UGM9H.css\":\"f8ec05f55e6ffeb2c0ecf622c8f86b9bcd1e9fc4197c1fb4ed8135c322d9d1a4\",\"assets/Call-5PLidRqz.js\":\"ac4acabf08b33931b05dcea6a08744d094c27fe1864b122c96450afb4ba34718\",\"assets/Call-BH-FlvRt.css\":\"72c27a044611bd5e73568c62521730576fefce8c2a7bc35fb38ab268f89da215\",\"assets/Display-DwhatFDA.js\":\"7ea94543a74ab0deb7039a0de002fc4bba95f99049010f601b3e327787c34528\",\"assets/Display-hbDRwTTd.css\":\"c83eeecb550859a06b9cd577a58e8c226d9ef24d37e0f7fb05ec1f901b52e67e\",\"assets/Drive-C8Tq45Zd.css\":\"08011867db62c8cb3b9c12a4042ef6bb9ec597d6a95f74b6b314a7d790941e10\",\"assets/Drive-CK3O7Xh5.js\":\"eea3ddb690633d5a5ec3ff33e04c16fca395f8813601d87768260aec5e389f1c\",\"assets/Joints-CEehP-Na.js\":\"9fa1c7d9ffaf4e03d2aa04b3314c510477f02194a5b5040968cff8d737b7b1e8\",\"assets/Motions-DTmtowIs.css\":\"74f4e85481e71bfcd588edda731de4d747c10ec024662e83369e4c350bc0b733\",\"assets/Motions-rdnQhR__.js\":\"a17bfd9d106d7aefd42970f064328a865ecad6ca757ce1e786e7cb09dbcfd9eb\",\"assets/System-DDx4SAUs.css\":\"3ee00a8d95ac92c760a3c7567de726908c8490d3599974ee01bd3177aea6c921\",\"assets/System-DhDb2EK7.js\":\"6a7602960166155d23cfefe5fbaaeb71630b5e5353739e91066979c2aae34df7\",\"assets/index-Brl09WXq.js\":\"1e269898b7ec3c10193bc670a1f23fac00436b3c61fdd4e27d3dde6e299b51f3\",\"assets/index-DIAhJi-2.css\":\"d0e765591aba08caf1fe52118718837f19e698789e9e691ba5b71b02e6cde5be\",\"assets/manage-cyXLhcR0.js\":\"5953dc7a80a3a178acc945d9024146a44cf7bed5b208060045eda4e97e5e9816\",\"assets/model-Bx7yEgVu.css\":\"802b384b1a54f70974f60851ef6bb609817b19f6c569ccb15816cb9f8a7b4e9f\",\"assets/model-DUf9FjKH.js\":\"fea4ffda9292e07fcd8065fc4f0afb123926cc8fbcdd2feb3a98a428375b88ae\",\"assets/parts-B-ggAMtm.js\":\"b62aebcf595476dafd0e26d198bc88f915e7dc0dea4bae23a6b3d9e465c4a185\",\"assets/saving-DbPjuOQb.js\":\"94d1a2e76767f7fdfe2e444b94c2326a340904bc4ede0b5445dbbf7236821d66\",\"assets/stage-32Y34p3Y.js\":\"fcbc469be217a3ddd44daafe2dd732e5b935287e16af870a92ad604f45914955\",\"assets/stream-DOiXKGBG.js\":\"56953c4611ed4fa2c9ae73b4f887b10080c566704a507f451ba3d2a14148fdc6\",\"assets/uPlot-CnsZ1jie.css\":\"0fd9465202f6dfceac29e67c17e5ac9fb1b7ba7615c1bb08782391b791d9f1e0\",\"assets/uPlot.esm-BScb58at.js\":\"068506d72590b07d0e53e012ff1541813c52c09bded848b3f97fcd1d4b0fd3b2\",\"icon-192.png\":\"df4dde7d57f1963226b36d9501a3b173c02eddc858bef226ae0176dbb4b7ee19\",\"icon-512.png\":\"6e797a05bab65afa3472b6a2bbc42b2f7a33115ab789fa2403c592655657e04d\",\"icon-maskable.png\":\"98caea4e0138a5272161323354bea3585ecac298ff8576823258aeddee01a45f\",\"icon.svg\":\"d12d71c61b9b10bf6b04ba84d91497c272291cd0830c21d5ca98ce2c771fabf2\",\"index.html\":\"136d5b3657ebcd619903ea82234dda98d0ff97c351a12ca1bb26ae95551310cc\",\"page.webmanifest\":\"909a00587727949215a61974b50bfb8f15bda9c788e30bb4cdae5af19732dc86\"}");
/** What the page itself names: enough to say that the robot is away. */
const SHELL = JSON.parse("[\"index.html\",\"icon.svg\",\"icon-192.png\",\"page.webmanifest\",\"assets/index-Brl09WXq.js\",\"assets/parts-B-ggAMtm.js\",\"assets/index-DIAhJi-2.css\"]");
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
