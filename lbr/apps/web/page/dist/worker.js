// Keeps the page for a robot that is off or far: the files that it was built with, each checked by its digest, and nothing
// else. What the robot says is never kept. The build fills in the names.
const BUILD = "35185088f685da65";
/** @type {Record<string, string>} */
const FILES = JSON.parse("{\"assets/Behaviours-CW6UGM9H.css\":\"f8ec05f55e6ffeb2c0ecf622c8f86b9bcd1e9fc4197c1fb4ed8135c322d9d1a4\",\"assets/Behaviours-W31_awvE.js\":\"03ad3c50abafc8b275a5d88c8b5a65442daad5804a024f9667cf59f417eb0949\",\"assets/Call-BH-FlvRt.css\":\"72c27a044611bd5e73568c62521730576fefce8c2a7bc35fb38ab268f89da215\",\"assets/Call-CbRoOL09.js\":\"86c2123bcd0b93854698d893828664cf8fc5d962c82d57507e8e908ccbe09c26\",\"assets/Display-RWMGJVmd.js\":\"95d1241d685ad4c2ad68080f3ba35684c567e753f62b8e45174eecc5f2f39b2c\",\"assets/Display-hbDRwTTd.css\":\"c83eeecb550859a06b9cd577a58e8c226d9ef24d37e0f7fb05ec1f901b52e67e\",\"assets/Drive-C8Tq45Zd.css\":\"08011867db62c8cb3b9c12a4042ef6bb9ec597d6a95f74b6b314a7d790941e10\",\"assets/Drive-DF33QFUW.js\":\"58ea02d33c608b0af2798d3e04e522a7672d91bf04ea27d597f10d3586204d7f\",\"assets/Joints-Zel37_3b.js\":\"e45f58b0b0214b5d1956ad94e6e3f2ef0a0dcb60d9877811e96a52efb257f063\",\"assets/Motions-D5-8a46a.js\":\"93639945985892e6d82f01c3dd0d0c1f8c23d3ccd7f23b3e3bf277e97ffdfca4\",\"assets/Motions-DTmtowIs.css\":\"74f4e85481e71bfcd588edda731de4d747c10ec024662e83369e4c350bc0b733\",\"assets/System-C_pu0E98.js\":\"5732b9123067bc9f238971952203ae9dcb7074cd7c1e3a4e2b449e89474805c4\",\"assets/System-DDx4SAUs.css\":\"3ee00a8d95ac92c760a3c7567de726908c8490d3599974ee01bd3177aea6c921\",\"assets/index-DD4ZzC6d.js\":\"35b2ca4a8e73718a9671685194d304835efb25969206f04cdb840ba972e68b12\",\"assets/index-DIAhJi-2.css\":\"d0e765591aba08caf1fe52118718837f19e698789e9e691ba5b71b02e6cde5be\",\"assets/manage-F1NPmOAp.js\":\"22a3a9013a50a7078bf561e970ebe07dc546b8a397a0298d46bd312ad287ea69\",\"assets/model-Bx7yEgVu.css\":\"802b384b1a54f70974f60851ef6bb609817b19f6c569ccb15816cb9f8a7b4e9f\",\"assets/model-G5t3y2uL.js\":\"7310db0d5f7bb2082bff06a553b539d333198c09fb7411f041f30880bbfdb871\",\"assets/parts-TGDUWbFh.js\":\"03197d0e1a6318a41b41f8bfd91878c3958862c448c5e0a61eb78d1586fb7a05\",\"assets/saving-DbPjuOQb.js\":\"94d1a2e76767f7fdfe2e444b94c2326a340904bc4ede0b5445dbbf7236821d66\",\"assets/stage-C2VvFbBk.js\":\"c61d94d979b5ce5cb706f178e2b4123fd3379a6bb0c26cd158ef16d89402ee23\",\"assets/stream-BhcBvyXk.js\":\"ac7e1597739fe3d7421aa00aba5b89d8701a09c2b1d068457264dba28e2fc055\",\"assets/uPlot-CnsZ1jie.css\":\"0fd9465202f6dfceac29e67c17e5ac9fb1b7ba7615c1bb08782391b791d9f1e0\",\"assets/uPlot.esm-BScb58at.js\":\"068506d72590b07d0e53e012ff1541813c52c09bded848b3f97fcd1d4b0fd3b2\",\"icon-192.png\":\"df4dde7d57f1963226b36d9501a3b173c02eddc858bef226ae0176dbb4b7ee19\",\"icon-512.png\":\"6e797a05bab65afa3472b6a2bbc42b2f7a33115ab789fa2403c592655657e04d\",\"icon-maskable.png\":\"98caea4e0138a5272161323354bea3585ecac298ff8576823258aeddee01a45f\",\"icon.svg\":\"d12d71c61b9b10bf6b04ba84d91497c272291cd0830c21d5ca98ce2c771fabf2\",\"index.html\":\"21f514ded105914cc76bb32dde5c43f1d04bedb5cd0bdb76770e4a0a45ae1a4e\",\"page.webmanifest\":\"909a00587727949215a61974b50bfb8f15bda9c788e30bb4cdae5af19732dc86\"}");
/** What the page itself names: enough to say that the robot is away. */
const SHELL = JSON.parse("[\"index.html\",\"icon.svg\",\"icon-192.png\",\"page.webmanifest\",\"assets/index-DD4ZzC6d.js\",\"assets/parts-TGDUWbFh.js\",\"assets/index-DIAhJi-2.css\"]");
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
