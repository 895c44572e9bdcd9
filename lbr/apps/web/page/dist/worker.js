// Keeps the page for a robot that is off or far: the files that it was built with, each checked by its digest, and nothing
// else. What the robot says is never kept. The build fills in the names.
const BUILD = "c6f54a4e0d231ebc";
/** @type {Record<string, string>} */
const FILES = JSON.parse("{\"assets/Behaviours-B2NjDl2w.js\":\"cab7724e79d5b98e18fa6dfd42ceaac151931b483f7c05aa660684ba63927140\",\"assets/Behaviours-CW6UGM9H.css\":\"f8ec05f55e6ffeb2c0ecf622c8f86b9bcd1e9fc4197c1fb4ed8135c322d9d1a4\",\"assets/Below-BtnjLvdO.js\":\"e106b9223bab6999256a0002d1c7d66a5a10aecf59a27a7fad3ef3cd2944f75b\",\"assets/Call-BH-FlvRt.css\":\"72c27a044611bd5e73568c62521730576fefce8c2a7bc35fb38ab268f89da215\",\"assets/Call-nxtrlb1h.js\":\"2a48f665e87c009df9c1dfd22fa19d1cc6dfd835acf7960e6c4454037db921ee\",\"assets/Display-B18aOUiI.js\":\"2b3b14e34251a329ba600b01a28d7bde2aa27b7d9215d47a58f446d5574e91b0\",\"assets/Display-hbDRwTTd.css\":\"c83eeecb550859a06b9cd577a58e8c226d9ef24d37e0f7fb05ec1f901b52e67e\",\"assets/Drive-CguKo-Or.css\":\"502d412c4055f2c0f7d9d3a0c36f04fb07c4402f07fc5410662c1d7eb0c43be9\",\"assets/Drive-CqfdE-gm.js\":\"97ba923a0f707969e36100e0d6ee04497b9d587a72fcd4861a624772a3132b48\",\"assets/Joints-BYViKyoL.js\":\"ab009bd068a158fc55609a92757164b07dfd433e7db50901d62ec99955fca843\",\"assets/Lacking-CacvYTQJ.css\":\"c7c4f4a3d3af03716a518f6da6ec94b34d1ffc67385869d3316d0f32ce4ddef3\",\"assets/Lacking-T2s1P0Ef.js\":\"0195f7911a3907f85d06c69ab634403a57400bb5453d87bdc653214c62cd103e\",\"assets/Log-eTNzxSdb.js\":\"c03834f252dfdddbfe5ac62379f2c2efae7d99024b383ee8307798d114a8b05d\",\"assets/Motions-CJQoRpbq.css\":\"da3e78579f8d170defd81f9b2104226e0f00b6d94db24d4203e26b51d8c102ac\",\"assets/Motions-Dl6sAoIF.js\":\"691607941fec8b2429578408592791bb4f95cd594361ffcebcd41715793dc024\",\"assets/System-BpVmK3WN.js\":\"fdeb17ada21b17b2c1119e68f059854fb07be7cf22bab65191ae09c365ba7bc1\",\"assets/System-CAGU8Dof.css\":\"ae933e9c36299104bd16c32c77243303a9aac415f91195177bf4a3e59a11cf9e\",\"assets/access-BLJYWfzU.js\":\"20c3886823d889efcaba9824c0c930bead3fa15055a35a5618c66134141b6003\",\"assets/connection-DU6vOJdI.js\":\"c195f39482a8a49cc527ce6a3b10d904e0ea878fe9e4c987413954e1607ec377\",\"assets/data-r4cNlhln.js\":\"f64fa83332ff522741905bc78dfe97829a1c51144d869800b33df7c942e9e1e5\",\"assets/index-C_PbGOJ1.js\":\"420ab0a23ab4c9e3dbe400e7abd7424d1b77daca66b9c80226976a1520ea3626\",\"assets/index-DWdO08Zv.css\":\"0cd8bc74e233b4a804728e823f79b07fd598f349fd123c2d8f28fb5db89f60d2\",\"assets/manage-DMhzK8LI.js\":\"0e0763e09cc1777fbc67ba7a7ba7cba254d958119cae958d281a65b916a7b823\",\"assets/model-BhDZKaW7.css\":\"6c5740c3b5ac779d9bac281576b4fbb48c5da54a165bce2a4712f8052b110d74\",\"assets/model-D57xmu0I.js\":\"6138119e41c44b6d92d553eccb75fe29b115c99635dc8fb30517a95b068fb1b0\",\"assets/news-DXxJX5bv.js\":\"de00397e45ca6244cfbbbf36b33e5cba7483c6c8efa5cbeecead3565cc9c2362\",\"assets/parts-D4gLQHAP.js\":\"861244615d263158d1500ecb36e446ca06c0464f222d536768d23ad140b82a42\",\"assets/stage-CMpL6uTv.js\":\"e8e6c9225bbaca9b1ab6d079488e5168222fddfcc33f06e0e2bb7cf5baf6dd32\",\"assets/stream-BHI2ETUu.js\":\"2e93cc91340427f22bbbce868b10f96d815c0490952bac9bc50b9a3910c26383\",\"assets/uPlot-CnsZ1jie.css\":\"0fd9465202f6dfceac29e67c17e5ac9fb1b7ba7615c1bb08782391b791d9f1e0\",\"assets/uPlot.esm-BScb58at.js\":\"068506d72590b07d0e53e012ff1541813c52c09bded848b3f97fcd1d4b0fd3b2\",\"favicon.ico\":\"eb66fde2ce87c9f33228184353f8a8c7ff0517cd76eaf9d6a94759bbd7276be9\",\"icon-192.png\":\"df4dde7d57f1963226b36d9501a3b173c02eddc858bef226ae0176dbb4b7ee19\",\"icon-512.png\":\"6e797a05bab65afa3472b6a2bbc42b2f7a33115ab789fa2403c592655657e04d\",\"icon-maskable.png\":\"98caea4e0138a5272161323354bea3585ecac298ff8576823258aeddee01a45f\",\"icon.svg\":\"d12d71c61b9b10bf6b04ba84d91497c272291cd0830c21d5ca98ce2c771fabf2\",\"index.html\":\"917d2c9f54b9ab5369dc9a6e8c323259def035d2290e59bb071ab4b8100fd705\",\"page.webmanifest\":\"909a00587727949215a61974b50bfb8f15bda9c788e30bb4cdae5af19732dc86\"}");
/** What the page itself names: enough to say that the robot is away. */
const SHELL = JSON.parse("[\"index.html\",\"icon.svg\",\"icon-192.png\",\"page.webmanifest\",\"assets/index-C_PbGOJ1.js\",\"assets/access-BLJYWfzU.js\",\"assets/parts-D4gLQHAP.js\",\"assets/index-DWdO08Zv.css\"]");
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
