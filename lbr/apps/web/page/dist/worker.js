// Keeps the page for a robot that is off or far: the files that it was built with, each checked by its digest, and nothing
// else. What the robot says is never kept. The build fills in the names.
const BUILD = "db29fff8195bf0fb";
/** @type {Record<string, string>} */
const FILES = JSON.parse("{\"assets/Behaviours-C6vqN4-d.js\":\"a833501cd30894ddec5d1f8838a47e41acde8d3d27363472a4cf7e32b8e6587c\",\"assets/Behaviours-CW6UGM9H.css\":\"f8ec05f55e6ffeb2c0ecf622c8f86b9bcd1e9fc4197c1fb4ed8135c322d9d1a4\",\"assets/Below-BBm0fGms.js\":\"c8b57e2df31ac80da9b3639731696eb9afcf8b37a74973cc490a0612f1cda19b\",\"assets/Call-BH-FlvRt.css\":\"72c27a044611bd5e73568c62521730576fefce8c2a7bc35fb38ab268f89da215\",\"assets/Call-DG6jQUNn.js\":\"d5b413c10e2fe9c78719fd7895047a1fb5225387992524078983c51c41fcba5d\",\"assets/Display-DwQ0drux.js\":\"e2214a9d02a6b8db914a723ad6f11a774fb91bb85501a79a95d7a14d7c794424\",\"assets/Display-hbDRwTTd.css\":\"c83eeecb550859a06b9cd577a58e8c226d9ef24d37e0f7fb05ec1f901b52e67e\",\"assets/Drive-C7fV0WwG.css\":\"9f36af9e8f4dd18ad7b833878ca4baf3e08aceeb3d22084309d223bb051172bc\",\"assets/Drive-DydlUKeT.js\":\"eac4158197b70f89978fa8bc2ca79506b33313de561bbe90bc6d1be88a49d874\",\"assets/Joints-3uDY-Nfk.js\":\"b82a81fcd0ff6e1036925f569c9f69ae5dd79bdd35dbc35768b8e1ce564b73dc\",\"assets/Lacking-CacvYTQJ.css\":\"c7c4f4a3d3af03716a518f6da6ec94b34d1ffc67385869d3316d0f32ce4ddef3\",\"assets/Lacking-DkR4KWQb.js\":\"3c2fb7ba30b5cf42b026f3f2766ca3f6cca63d14a32f1b764be24d57e5d93b4d\",\"assets/Log-CxlMzHSz.js\":\"b579c44d8f8aff0c99b9a6f3e5c0dd5f4f6e2fce6c58ef3e4e096189ff39bc2c\",\"assets/Motions-oUjdf7TJ.js\":\"030f1a3d682355559d5089141ddf663877f37be9fe038e621d313550f48f5762\",\"assets/Motions-paJ-cc2G.css\":\"57d2fce9f4270827406c9d4b7c5d5cfcaa268387e079fa275368e32c9922b3f1\",\"assets/System-C1cfcnJV.js\":\"c17fd09d6d4c6b228d1d167c91c8425b7eced8c23151c81337c6823b8bcc23b8\",\"assets/System-CAGU8Dof.css\":\"ae933e9c36299104bd16c32c77243303a9aac415f91195177bf4a3e59a11cf9e\",\"assets/access-CDdFy0RP.js\":\"e6251fffbfcadce9a4379e494f348bde33ee768212c400f07bd8eff39437eddc\",\"assets/connection-COs4CRlx.js\":\"e791acecbf114dafdb2c3229eeddbbc9bd45e53777f4ac9f317e1804d173fd3c\",\"assets/data-Cf0C-frz.js\":\"cc602f7da82c7637724dc4f9904042e2f7eac7d347edf1609634c1db10873a60\",\"assets/index-DFQgke9m.js\":\"d0975b8ecaef317189a5a8f98d164e5b994b15004db33a58b9124a1b1291f13e\",\"assets/index-DWdO08Zv.css\":\"0cd8bc74e233b4a804728e823f79b07fd598f349fd123c2d8f28fb5db89f60d2\",\"assets/manage-ByRvD5yf.js\":\"0a302e967824626c360026b5226a88f637719956aa7670ea5ced8f5c209e1eee\",\"assets/model-057TCHNR.js\":\"494e17934ba2d424e4e28da662305b41ebd59e0b01980a7b875495faca7e3acf\",\"assets/model-BQf9Q56Z.css\":\"4858a97611324655e63ebff70fa3db9c59160f1874dd8624eb0c909bc3137a55\",\"assets/news-CMBf6NuX.js\":\"6e1d857c257578fed5ed03981377378c642b488a4a8d3ee1a6160aa050746448\",\"assets/parts-CblYZRS3.js\":\"c8c1eb6984caa7b74856d6fa8d15830205c550dcf3c1e8773b700d893b1332ce\",\"assets/stage-Bt-Qa_4U.js\":\"db3e7107f752bcdd9160cbf9b33c95adb54284e46263c7d75eabba9b5c916d15\",\"assets/stream-BnZpFnG1.js\":\"5fd2a80799a2d3ef8e9044d84f0593164c30cc8f3667b291fe19cc5fdedbf1bd\",\"assets/uPlot-CnsZ1jie.css\":\"0fd9465202f6dfceac29e67c17e5ac9fb1b7ba7615c1bb08782391b791d9f1e0\",\"assets/uPlot.esm-BScb58at.js\":\"068506d72590b07d0e53e012ff1541813c52c09bded848b3f97fcd1d4b0fd3b2\",\"favicon.ico\":\"eb66fde2ce87c9f33228184353f8a8c7ff0517cd76eaf9d6a94759bbd7276be9\",\"icon-192.png\":\"df4dde7d57f1963226b36d9501a3b173c02eddc858bef226ae0176dbb4b7ee19\",\"icon-512.png\":\"6e797a05bab65afa3472b6a2bbc42b2f7a33115ab789fa2403c592655657e04d\",\"icon-maskable.png\":\"98caea4e0138a5272161323354bea3585ecac298ff8576823258aeddee01a45f\",\"icon.svg\":\"d12d71c61b9b10bf6b04ba84d91497c272291cd0830c21d5ca98ce2c771fabf2\",\"index.html\":\"4f537e70ffe3fb492e3a4facb27b3acf7917d672ca3a5f6dda05e146f6b53e9f\",\"page.webmanifest\":\"909a00587727949215a61974b50bfb8f15bda9c788e30bb4cdae5af19732dc86\"}");
/** What the page itself names: enough to say that the robot is away. */
const SHELL = JSON.parse("[\"index.html\",\"icon.svg\",\"icon-192.png\",\"page.webmanifest\",\"assets/index-DFQgke9m.js\",\"assets/access-CDdFy0RP.js\",\"assets/parts-CblYZRS3.js\",\"assets/index-DWdO08Zv.css\"]");
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
