// Keeps the page for a robot that is off or far: the files that it was built with, each checked by its digest, and nothing
// else. What the robot says is never kept. The build fills in the names.
const BUILD = "7a97985df475a35c";
/** @type {Record<string, string>} */
const FILES = JSON.parse("{\"assets/Behaviours-CW6UGM9H.css\":\"f8ec05f55e6ffeb2c0ecf622c8f86b9bcd1e9fc4197c1fb4ed8135c322d9d1a4\",\"assets/Behaviours-CbDPrZpO.js\":\"99d2da89a3dd78f2cade5ada47685500c7b186e6ca545c5a45629eb6a5371e29\",\"assets/Below-BdZ5hm-m.js\":\"48d9a126b5e28b1beeb37e121571dbfebddf3799aa60244733f591f50adbb2be\",\"assets/Call-BH-FlvRt.css\":\"72c27a044611bd5e73568c62521730576fefce8c2a7bc35fb38ab268f89da215\",\"assets/Call-DDhggrSh.js\":\"3222e1d759026f6204446f1d31987f398428956122bb12f18a5c21536c0d5ce3\",\"assets/Display-5iiBz4YU.js\":\"20a67808f174e3e95ea56887c659abe50fc1569134acff8f5df466eecfaf1be8\",\"assets/Display-hbDRwTTd.css\":\"c83eeecb550859a06b9cd577a58e8c226d9ef24d37e0f7fb05ec1f901b52e67e\",\"assets/Drive-6AUfHx9_.js\":\"5cbbd00d88d1d503a9ad99227f57543d7a1054aee4066067940a1e25be2432b8\",\"assets/Drive-CguKo-Or.css\":\"502d412c4055f2c0f7d9d3a0c36f04fb07c4402f07fc5410662c1d7eb0c43be9\",\"assets/Joints-BeNHQUSr.js\":\"cdf1009c99b136915cffdf7252842aa4589e120df01882385b518f8ff8c94072\",\"assets/Lacking-CacvYTQJ.css\":\"c7c4f4a3d3af03716a518f6da6ec94b34d1ffc67385869d3316d0f32ce4ddef3\",\"assets/Lacking-CjqEVWzv.js\":\"7445c02f35081e23b3951d3cba105455a58ed7bc48f235ebddfbfad77f65b16b\",\"assets/Log-B7ka8ssF.js\":\"1b14db4439f1146b3cc37cf2caa39cb88089cde2e267ac0378585dbef7b1e603\",\"assets/Motions-BK3Rrsdu.css\":\"5423ace46b17bffaa4bdfbcf2303eaf0fa3f1a14b9693db32015687986025d11\",\"assets/Motions-B_F6kju0.js\":\"ea7e6ed552ae36a0aadf9938641b5a136f4b8baee583548503871a8a5768fb68\",\"assets/System-CAGU8Dof.css\":\"ae933e9c36299104bd16c32c77243303a9aac415f91195177bf4a3e59a11cf9e\",\"assets/System-Cof2wKR8.js\":\"f1f37af47334ecc5f2b7b791952d97030b30dbd83e6959e2ca8c75de65009bc1\",\"assets/access-BQHRADkw.js\":\"f9d7f00c4c2f087cabaea6dbfa94496f17fe8fbb0e796dc137f10819988791ed\",\"assets/connection-C2LEzJ-Q.js\":\"5d1025cf42068691452e57039ecd5b785f76eda54eb32a9781e2f9fc8487a8b9\",\"assets/data-nZrYUvur.js\":\"035d4ee153c60e6f3205c898814c0decba58c1174bb7fdba694d138746004a06\",\"assets/index-9AYQEbQg.js\":\"c85d03f5f115e2444153ad1fb4fb8d48fa7c29640fe551500174b39c5532cbf9\",\"assets/index-DWdO08Zv.css\":\"0cd8bc74e233b4a804728e823f79b07fd598f349fd123c2d8f28fb5db89f60d2\",\"assets/manage-BzRzopOr.js\":\"9451ccefbbfbb269d29628aaa39a03f828f4d44f366434f7ee35683f6db15e48\",\"assets/model-B_O0fmDU.css\":\"282b1cc84bddd70cb9bb54d0f6f1e2d6f0f6fbad8b72b2187e9001ef812ca75e\",\"assets/model-C-uMbsW7.js\":\"5da51488958f5e2dd18e59a79706e9334d2c2658121d9386608cea0b98954135\",\"assets/news-Ba4BXJWn.js\":\"0cef6818bca4ac50d0d7fea1b4a4eb01377f403954fe837c74654c66ba3e2215\",\"assets/parts-DZRC7PJ9.js\":\"fe2b69662f6f90a1b437464c08304142019e1fe0a8877c1a28a13dc19183958b\",\"assets/stage-BosK5amW.js\":\"1859dbb94b2c0ba064cd5c0e8a782bf696ed9aa349446e04a01aa9325f3d382c\",\"assets/stream-BandjUVI.js\":\"712197480627ad7ab1949a46d884bb3828feb4e025d907a83b68e57d149777e3\",\"assets/uPlot-CnsZ1jie.css\":\"0fd9465202f6dfceac29e67c17e5ac9fb1b7ba7615c1bb08782391b791d9f1e0\",\"assets/uPlot.esm-BScb58at.js\":\"068506d72590b07d0e53e012ff1541813c52c09bded848b3f97fcd1d4b0fd3b2\",\"favicon.ico\":\"eb66fde2ce87c9f33228184353f8a8c7ff0517cd76eaf9d6a94759bbd7276be9\",\"icon-192.png\":\"df4dde7d57f1963226b36d9501a3b173c02eddc858bef226ae0176dbb4b7ee19\",\"icon-512.png\":\"6e797a05bab65afa3472b6a2bbc42b2f7a33115ab789fa2403c592655657e04d\",\"icon-maskable.png\":\"98caea4e0138a5272161323354bea3585ecac298ff8576823258aeddee01a45f\",\"icon.svg\":\"d12d71c61b9b10bf6b04ba84d91497c272291cd0830c21d5ca98ce2c771fabf2\",\"index.html\":\"a8b1590c271ce6ccd6000ef33345124943335ba43a3151c5699a9dd284f8f0a7\",\"page.webmanifest\":\"909a00587727949215a61974b50bfb8f15bda9c788e30bb4cdae5af19732dc86\"}");
/** What the page itself names: enough to say that the robot is away. */
const SHELL = JSON.parse("[\"index.html\",\"icon.svg\",\"icon-192.png\",\"page.webmanifest\",\"assets/index-9AYQEbQg.js\",\"assets/access-BQHRADkw.js\",\"assets/parts-DZRC7PJ9.js\",\"assets/index-DWdO08Zv.css\"]");
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
