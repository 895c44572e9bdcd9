// Keeps the page for a robot that is off or far: the files that it was built with, each checked by its digest, and nothing
// else. What the robot says is never kept. The build fills in the names.
const BUILD = "0c552a946a9343e1";
/** @type {Record<string, string>} */
const FILES = JSON.parse("{\"assets/Behaviours-CW6UGM9H.css\":\"f8ec05f55e6ffeb2c0ecf622c8f86b9bcd1e9fc4197c1fb4ed8135c322d9d1a4\",\"assets/Behaviours-Drp8Tbn8.js\":\"57d2e08d1780cada0e89be128a51bc29f0b674099f43f876c517d6580d60000f\",\"assets/Below-S0-Nl5BS.js\":\"e14c448eb7577c2cfa5fd6f2839d5e0d8875cf316ff7fa14d1d4846ca1c21255\",\"assets/Call-BH-FlvRt.css\":\"72c27a044611bd5e73568c62521730576fefce8c2a7bc35fb38ab268f89da215\",\"assets/Call-BqlJqAxO.js\":\"aa5c888c237010e436d35dfff83ceca97d682c384ab4d272ec5438c904af4c7c\",\"assets/Display-BUB7iNUW.js\":\"27274addfe3e606b81ef1802276ec1f6a34b63303eb10c20bb384200af87e62a\",\"assets/Display-hbDRwTTd.css\":\"c83eeecb550859a06b9cd577a58e8c226d9ef24d37e0f7fb05ec1f901b52e67e\",\"assets/Drive-C7fV0WwG.css\":\"9f36af9e8f4dd18ad7b833878ca4baf3e08aceeb3d22084309d223bb051172bc\",\"assets/Drive-CW2psGqA.js\":\"69eb768bef046e35b7d6f22f67486d3a80259a3aa301c96ee4019f623ce24dd7\",\"assets/Joints-CpqQgIKW.js\":\"5d45f5cbcad2d2e1b34d6f83beefc221e9d4bae01bed49bcb84bd8d198e8ef17\",\"assets/Lacking-COd-Pxcs.js\":\"432795f63c587d36cbb44ef627cdde62c6ebaff0aa1bdbc8bf7262c9ab26eb99\",\"assets/Lacking-CacvYTQJ.css\":\"c7c4f4a3d3af03716a518f6da6ec94b34d1ffc67385869d3316d0f32ce4ddef3\",\"assets/Log-CF4bfcOv.js\":\"f3947c5dc3caaf516b50461c0d3912a102a7f397c3b8115325544297f7170966\",\"assets/Motions-BV4uc-ev.js\":\"00a5fda006f05af53e4e0f5be100dcb7c6f8ae0915891328e1edc1b12b56975d\",\"assets/Motions-paJ-cc2G.css\":\"57d2fce9f4270827406c9d4b7c5d5cfcaa268387e079fa275368e32c9922b3f1\",\"assets/System-CAGU8Dof.css\":\"ae933e9c36299104bd16c32c77243303a9aac415f91195177bf4a3e59a11cf9e\",\"assets/System-ZIR8gLTy.js\":\"25ff4ef276bcc7275d5442f79ea56b373043e3377cff16dbaf458e15cba537b1\",\"assets/access-CDdFy0RP.js\":\"e6251fffbfcadce9a4379e494f348bde33ee768212c400f07bd8eff39437eddc\",\"assets/connection-COs4CRlx.js\":\"e791acecbf114dafdb2c3229eeddbbc9bd45e53777f4ac9f317e1804d173fd3c\",\"assets/data-Cl4bmoVJ.js\":\"29e9f2fa5a44f4e8944742ba88ad81607253d6498973b1a8bded0356e04e6150\",\"assets/index-DWdO08Zv.css\":\"0cd8bc74e233b4a804728e823f79b07fd598f349fd123c2d8f28fb5db89f60d2\",\"assets/index-v3tNc9dg.js\":\"a20a7341b5df6e29f724c98177f8edc8dcf99402b9b637292b4ed92efdda8aa6\",\"assets/manage-Dnq1FU9q.js\":\"5af3fe00feed9e4ddf0f7432e3ce5cef9d5778940567ee710ff9ca29a98a0b8f\",\"assets/model-B-ZVfUmG.js\":\"0327890d8c60363a6457a7cd9c2826bd57afff588dd2c038ada6090a7fcb8859\",\"assets/model-BQf9Q56Z.css\":\"4858a97611324655e63ebff70fa3db9c59160f1874dd8624eb0c909bc3137a55\",\"assets/news-C-wUD-5p.js\":\"cd619f60afa2725f710127d8b632f328f59b32a34fa98858112291cc838badcb\",\"assets/parts-BfKNVHV0.js\":\"2952e99532a21f2f77bfd6e83d009893b257bcf0076d225bea2da9a2959d5b4f\",\"assets/stage-BU4sfyJU.js\":\"7009b0d5cb940253f4831ef669156b5e6aeb5f65ff138bc89f51ea92d5d9ca90\",\"assets/stream-C9gkUahB.js\":\"ae2154b930516efea36962909a149fca3c1cf07fcf49f1d2713d7e88fd73b61c\",\"assets/uPlot-CnsZ1jie.css\":\"0fd9465202f6dfceac29e67c17e5ac9fb1b7ba7615c1bb08782391b791d9f1e0\",\"assets/uPlot.esm-BScb58at.js\":\"068506d72590b07d0e53e012ff1541813c52c09bded848b3f97fcd1d4b0fd3b2\",\"favicon.ico\":\"eb66fde2ce87c9f33228184353f8a8c7ff0517cd76eaf9d6a94759bbd7276be9\",\"icon-192.png\":\"df4dde7d57f1963226b36d9501a3b173c02eddc858bef226ae0176dbb4b7ee19\",\"icon-512.png\":\"6e797a05bab65afa3472b6a2bbc42b2f7a33115ab789fa2403c592655657e04d\",\"icon-maskable.png\":\"98caea4e0138a5272161323354bea3585ecac298ff8576823258aeddee01a45f\",\"icon.svg\":\"d12d71c61b9b10bf6b04ba84d91497c272291cd0830c21d5ca98ce2c771fabf2\",\"index.html\":\"e8b40cbcda0c036c237b210f4946dd42bcf2f2d9dd50675159348bc4bc960a2e\",\"page.webmanifest\":\"909a00587727949215a61974b50bfb8f15bda9c788e30bb4cdae5af19732dc86\"}");
/** What the page itself names: enough to say that the robot is away. */
const SHELL = JSON.parse("[\"index.html\",\"icon.svg\",\"icon-192.png\",\"page.webmanifest\",\"assets/index-v3tNc9dg.js\",\"assets/access-CDdFy0RP.js\",\"assets/parts-BfKNVHV0.js\",\"assets/index-DWdO08Zv.css\"]");
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
