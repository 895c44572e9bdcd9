// Keeps the page for a robot that is off or far: the files that it was built with, each checked by its digest, and nothing
// else. What the robot says is never kept. The build fills in the names.
const BUILD = "0f711c5007407c9c";
/** @type {Record<string, string>} */
const FILES = JSON.parse("{\"assets/Behaviours-CW6UGM9H.css\":\"f8ec05f55e6ffeb2c0ecf622c8f86b9bcd1e9fc4197c1fb4ed8135c322d9d1a4\",\"assets/Behaviours-D7c2sDar.js\":\"ee5e1d5ee0411db8664762adfd81295b0036ecacb3c64f360ab1d82af38e81f0\",\"assets/Below-CYvYeqbH.js\":\"6a4b8ff44f0c082368b1ae7f9e9a048bb2b83b3799037d5acc98dbd36b2e0d24\",\"assets/Call-BH-FlvRt.css\":\"72c27a044611bd5e73568c62521730576fefce8c2a7bc35fb38ab268f89da215\",\"assets/Call-CTrIvzKt.js\":\"ab82237af583fa00b1ae6b355ad09a4d5a3ca5a773b2e03c8bff68138e149654\",\"assets/Display-BnO6_LEs.js\":\"f83b1e0a12427e03c0ed019feae8e21686a6aeca6d98667633bd20c1ba2ff6f3\",\"assets/Display-hbDRwTTd.css\":\"c83eeecb550859a06b9cd577a58e8c226d9ef24d37e0f7fb05ec1f901b52e67e\",\"assets/Drive-CCgAIupe.js\":\"0a2aec908abd4ca12c5a498c78c73dece46ea0a6dd9890a342bb04359b50c7d2\",\"assets/Drive-CguKo-Or.css\":\"502d412c4055f2c0f7d9d3a0c36f04fb07c4402f07fc5410662c1d7eb0c43be9\",\"assets/Joints-BVaqB_q6.js\":\"e74b11512d7c9cc265efacac5f0bf0891586a158604b784186fda9399850aad4\",\"assets/Lacking-CRQna_Lx.js\":\"8829c742b24b0ccfcc2a6ab04678655462d55f37c1bb94002a8db9cbb8a2c5c2\",\"assets/Lacking-CacvYTQJ.css\":\"c7c4f4a3d3af03716a518f6da6ec94b34d1ffc67385869d3316d0f32ce4ddef3\",\"assets/Log-wwXLINen.js\":\"e6072c54af649b112bc8d8fb653b1657abe02173cb2021349cf2c1a8c3e625b1\",\"assets/Motions-DoGg1aYA.js\":\"de517e159a29a71afcd374d3df3fb6b97b226fc4ec93c11e490ff369d8834d33\",\"assets/Motions-paJ-cc2G.css\":\"57d2fce9f4270827406c9d4b7c5d5cfcaa268387e079fa275368e32c9922b3f1\",\"assets/System-CAGU8Dof.css\":\"ae933e9c36299104bd16c32c77243303a9aac415f91195177bf4a3e59a11cf9e\",\"assets/System-C_f6GCaP.js\":\"cfd857525136ab76570adff29369c87eea1f3cc23f21f353f562bf28d472349b\",\"assets/access-COpnzeB1.js\":\"b4ce70258f93b723c73cf68e0b86dc17288e9d21c1908c49b79a6f3b85463cb9\",\"assets/connection-BWPi9tx9.js\":\"75fd07c16a7d99f9a21e602defc06581b335e665176e1652cd0f7b1ae901cf4f\",\"assets/data-BHSwbYCK.js\":\"3b655b56c2074bd11e44c3bdc9e0dd774718f490047e6ebc8138344e45a85da6\",\"assets/index-BkX5ZyFy.js\":\"4684bf838ee80f542771f75aec2c69e62eeee2a6c8f432e6bd0d635164cda518\",\"assets/index-DWdO08Zv.css\":\"0cd8bc74e233b4a804728e823f79b07fd598f349fd123c2d8f28fb5db89f60d2\",\"assets/manage-CPEziYFo.js\":\"d5884ff3ea900a11b4784b59d3c62a3de7f71c9f2bf724001167240103ad86ce\",\"assets/model-B_O0fmDU.css\":\"282b1cc84bddd70cb9bb54d0f6f1e2d6f0f6fbad8b72b2187e9001ef812ca75e\",\"assets/model-pyoGJXLW.js\":\"b68addbbf88a9051fa529e35eb4566c1ce3a4bfc82f910e6c35e1f4f3d87229d\",\"assets/news-Cm9pjcPp.js\":\"9bcd3bfac1b0f2483bebb81a99907bbf34bf5520dda0cfacbb86bc4f50acdb1c\",\"assets/parts-CgWiatr1.js\":\"6104679ae7c085dd92f24a013a04b0694a755c3e1f66f77f2b894fce3815f2b2\",\"assets/stage-hWfSyGJO.js\":\"87100ea451ba01ffa2cd9485f2c03b464ed3d64fccebf79e1a78888069dceedd\",\"assets/stream-DCbhlaco.js\":\"727d60956c39a88cf33fc12b0904b16de4af951ea59f842af64ed8d1064f701a\",\"assets/uPlot-CnsZ1jie.css\":\"0fd9465202f6dfceac29e67c17e5ac9fb1b7ba7615c1bb08782391b791d9f1e0\",\"assets/uPlot.esm-BScb58at.js\":\"068506d72590b07d0e53e012ff1541813c52c09bded848b3f97fcd1d4b0fd3b2\",\"favicon.ico\":\"eb66fde2ce87c9f33228184353f8a8c7ff0517cd76eaf9d6a94759bbd7276be9\",\"icon-192.png\":\"df4dde7d57f1963226b36d9501a3b173c02eddc858bef226ae0176dbb4b7ee19\",\"icon-512.png\":\"6e797a05bab65afa3472b6a2bbc42b2f7a33115ab789fa2403c592655657e04d\",\"icon-maskable.png\":\"98caea4e0138a5272161323354bea3585ecac298ff8576823258aeddee01a45f\",\"icon.svg\":\"d12d71c61b9b10bf6b04ba84d91497c272291cd0830c21d5ca98ce2c771fabf2\",\"index.html\":\"eef356d6e7e498a7e9efd2e0a8a0b39ff7727d283b63d6214e39600978c36822\",\"page.webmanifest\":\"909a00587727949215a61974b50bfb8f15bda9c788e30bb4cdae5af19732dc86\"}");
/** What the page itself names: enough to say that the robot is away. */
const SHELL = JSON.parse("[\"index.html\",\"icon.svg\",\"icon-192.png\",\"page.webmanifest\",\"assets/index-BkX5ZyFy.js\",\"assets/access-COpnzeB1.js\",\"assets/parts-CgWiatr1.js\",\"assets/index-DWdO08Zv.css\"]");
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
