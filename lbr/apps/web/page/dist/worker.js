// Keeps the page for a robot that is off or far: the files that it was built with, each checked by its digest, and nothing
// else. What the robot says is never kept. The build fills in the names.
const BUILD = "927a65558722b390";
/** @type {Record<string, string>} */
const FILES = JSON.parse("{\"assets/Behaviours-CW6UGM9H.css\":\"f8ec05f55e6ffeb2c0ecf622c8f86b9bcd1e9fc4197c1fb4ed8135c322d9d1a4\",\"assets/Behaviours-DYiskRh_.js\":\"0a020033b10936556e79b322c4ed47296e2c7697741b4554b1b329cdd3fb823c\",\"assets/Below-DMByLwuj.js\":\"008f9b79226e25b23365493cd97078558c97d580d239c543f3a8867089932c24\",\"assets/Call-BH-FlvRt.css\":\"72c27a044611bd5e73568c62521730576fefce8c2a7bc35fb38ab268f89da215\",\"assets/Call-WX_EnK6q.js\":\"7ad3ee3889495d87a36d4ccb0a48b4d1f8430e7f38031e06a0b913d8f2c2f136\",\"assets/Display-B3NJT-np.js\":\"404c832e616658f6e4cd031e0c3df06fe4ecff9731caf48edbbc2a1d6c3ce56e\",\"assets/Display-hbDRwTTd.css\":\"c83eeecb550859a06b9cd577a58e8c226d9ef24d37e0f7fb05ec1f901b52e67e\",\"assets/Drive-B1BxCnzO.js\":\"04c0f705d6d1032b9a120f4a7a95efd3401e4b555f1e2a53b61df93566a98586\",\"assets/Drive-CguKo-Or.css\":\"502d412c4055f2c0f7d9d3a0c36f04fb07c4402f07fc5410662c1d7eb0c43be9\",\"assets/Joints-BqGCKKvw.js\":\"146998180f45744840240ba2c18bc53d733ce756833f50aebf79478271bd2cd9\",\"assets/Lacking-CacvYTQJ.css\":\"c7c4f4a3d3af03716a518f6da6ec94b34d1ffc67385869d3316d0f32ce4ddef3\",\"assets/Lacking-UbDJtqDh.js\":\"41d73e4459a7327c77a4403d7671ef955dd792c9ea56813de1dd9111edbc59d7\",\"assets/Log-BH0z-h_m.js\":\"1294aff6b6d0b981a9a6046429bfd588cdb7286c0acfd8b716b80a3070f3bfbe\",\"assets/Motions-DCV7xezK.js\":\"e4988e5ba154283ee9bb14be3b3b6be60134f8c70865f84189db6abe7851550d\",\"assets/Motions-paJ-cc2G.css\":\"57d2fce9f4270827406c9d4b7c5d5cfcaa268387e079fa275368e32c9922b3f1\",\"assets/System-BUbyBNJ4.js\":\"24e5d8ce001be80a76b477464785f43c2cc8fc10f4c603c7967efa0324c74f14\",\"assets/System-CAGU8Dof.css\":\"ae933e9c36299104bd16c32c77243303a9aac415f91195177bf4a3e59a11cf9e\",\"assets/access-COpnzeB1.js\":\"b4ce70258f93b723c73cf68e0b86dc17288e9d21c1908c49b79a6f3b85463cb9\",\"assets/connection-BWPi9tx9.js\":\"75fd07c16a7d99f9a21e602defc06581b335e665176e1652cd0f7b1ae901cf4f\",\"assets/data-Dj2NWmty.js\":\"24d1d2114bcab70b26074e33f151d13549484fbf98b1ac27da4ceee8ed9e8d3e\",\"assets/index-Boz9RTO4.js\":\"56c1abf073192ee4ef3014ae4b9a536284a05e8f5e6e6b1f87ed68633b19ad00\",\"assets/index-DWdO08Zv.css\":\"0cd8bc74e233b4a804728e823f79b07fd598f349fd123c2d8f28fb5db89f60d2\",\"assets/manage-DPK8P5Hs.js\":\"86fc9550e36154f6adba3106553b5a430727aea1a5bfe985197b38fce6be674b\",\"assets/model-B_O0fmDU.css\":\"282b1cc84bddd70cb9bb54d0f6f1e2d6f0f6fbad8b72b2187e9001ef812ca75e\",\"assets/model-CmQBnsNV.js\":\"000b75b8694755955ccd3b392eff0dee9966710d8d7e7fc877985e41f93b5cf1\",\"assets/news-C7dL3r2Q.js\":\"4db06141a6f941d5c1266e5755a3e62eb0a12d26ca12b9bac937a556204ee010\",\"assets/parts-CV3-oFZK.js\":\"494dd556fb595d57d55373010b45ced9378e9d5c41a856f6cd53243a26d61e21\",\"assets/stage-BUqiSUlZ.js\":\"a5875adf3c24d004189b13244d094c76c9d72767cc38deb5d12ee1042f460755\",\"assets/stream-DjAeHcvg.js\":\"89ed4d1e40bb3e94cda7400dcbde150da035a915d62ba457a9b1fcd996f09f7a\",\"assets/uPlot-CnsZ1jie.css\":\"0fd9465202f6dfceac29e67c17e5ac9fb1b7ba7615c1bb08782391b791d9f1e0\",\"assets/uPlot.esm-BScb58at.js\":\"068506d72590b07d0e53e012ff1541813c52c09bded848b3f97fcd1d4b0fd3b2\",\"favicon.ico\":\"eb66fde2ce87c9f33228184353f8a8c7ff0517cd76eaf9d6a94759bbd7276be9\",\"icon-192.png\":\"df4dde7d57f1963226b36d9501a3b173c02eddc858bef226ae0176dbb4b7ee19\",\"icon-512.png\":\"6e797a05bab65afa3472b6a2bbc42b2f7a33115ab789fa2403c592655657e04d\",\"icon-maskable.png\":\"98caea4e0138a5272161323354bea3585ecac298ff8576823258aeddee01a45f\",\"icon.svg\":\"d12d71c61b9b10bf6b04ba84d91497c272291cd0830c21d5ca98ce2c771fabf2\",\"index.html\":\"850b40d1b672601c192dda14dad12a6e9e8b86cbbf96510ec831220fb1b0f5d9\",\"page.webmanifest\":\"909a00587727949215a61974b50bfb8f15bda9c788e30bb4cdae5af19732dc86\"}");
/** What the page itself names: enough to say that the robot is away. */
const SHELL = JSON.parse("[\"index.html\",\"icon.svg\",\"icon-192.png\",\"page.webmanifest\",\"assets/index-Boz9RTO4.js\",\"assets/access-COpnzeB1.js\",\"assets/parts-CV3-oFZK.js\",\"assets/index-DWdO08Zv.css\"]");
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
