// Keeps the page for a robot that is off or far: the files that it was built with, each checked by its digest, and nothing
// else. What the robot says is never kept. The build fills in the names.
const BUILD = "5d76283e98d9babf";
/** @type {Record<string, string>} */
const FILES = JSON.parse("{\"assets/Behaviours-0CaZUIxV.js\":\"7e50ab8643d2d1f24ee4b8eda044eba623d18c4aaf3f3698da2afb4e631500be\",\"assets/Behaviours-CW6UGM9H.css\":\"f8ec05f55e6ffeb2c0ecf622c8f86b9bcd1e9fc4197c1fb4ed8135c322d9d1a4\",\"assets/Call-BH-FlvRt.css\":\"72c27a044611bd5e73568c62521730576fefce8c2a7bc35fb38ab268f89da215\",\"assets/Call-OG3awo0g.js\":\"f20e6927ffdd69f7ca480ef51fa58f3431b36e4cb91fad9890bcb4934bdf9a7d\",\"assets/Display-hbDRwTTd.css\":\"c83eeecb550859a06b9cd577a58e8c226d9ef24d37e0f7fb05ec1f901b52e67e\",\"assets/Display-lClafg57.js\":\"e4b93cb0b071300583cba4a46e62a42960b1bf8e4932610b7d6e6ac1fe9fb97a\",\"assets/Drive-C8Tq45Zd.css\":\"08011867db62c8cb3b9c12a4042ef6bb9ec597d6a95f74b6b314a7d790941e10\",\"assets/Drive-CUuO4Lqj.js\":\"bbbea2aa716c01dfaee814ab7d13b2f95e39cfb0a832f72d103d0c020fbb6784\",\"assets/Joints-rdwSekYJ.js\":\"7044b296a7ce8f5349441e7913f15b1520c0b48b5127de4dd837c5b397fdf860\",\"assets/Motions-CoUeG6QQ.css\":\"c7405ed80447ef97051d5de59d8b24ad9cce70b4956e89b2333a1e4c142f4c38\",\"assets/Motions-DMM_Rv2H.js\":\"5aed6837f5ff212b40cb1483e225b9e9da33b84e7d789720695885dddda81ce3\",\"assets/System-Dh6J8vRa.js\":\"9dac52ec27ff287d6283c990d1f7b323d53e6970de1cdd2e399e2e14f0a4401c\",\"assets/System-xJZzRxg6.css\":\"2d83ae9f9a033c027a167077f5d405b0a8a9e40b97a28f57c7d6949cb04c1462\",\"assets/index-DAU4znQf.js\":\"444dfff6652c007a9bd35ceacf383d03bd77d7569714cc0446f7a990d14fb04a\",\"assets/index-DIAhJi-2.css\":\"d0e765591aba08caf1fe52118718837f19e698789e9e691ba5b71b02e6cde5be\",\"assets/manage-CnJLf0vZ.js\":\"b1b3a7a30c5482fca8ea74bc31ad54e61c149db963193eaff5b3dbadf58c14c8\",\"assets/model-BOBRJSTj.js\":\"dbdbcf5266548a46cb607312c9bd9f761ef6f59c5535b0a117bf92b267b3c936\",\"assets/model-Bx7yEgVu.css\":\"802b384b1a54f70974f60851ef6bb609817b19f6c569ccb15816cb9f8a7b4e9f\",\"assets/news-By8W9t4C.js\":\"f45e2be90e6dbb18312b9a1e922634d8ea5cb2596dbf171be19b443ad95e202c\",\"assets/parts-DMOWGIgI.js\":\"9470bb76cc2f26292046e350096b157f70b38d7a2de45c659ecb67a18095012c\",\"assets/saving-DbPjuOQb.js\":\"94d1a2e76767f7fdfe2e444b94c2326a340904bc4ede0b5445dbbf7236821d66\",\"assets/stage-Bo9qQcAH.js\":\"c87bbe15ef11fbe80fd577062b5af92f2f8f6036569b80807bd281f1bef6d37c\",\"assets/stream-Dvx2TYm4.js\":\"448f5820b9ea41da593260b0c15a4ae35079e87bb9f6b0fd027546573f0dffcb\",\"assets/uPlot-CnsZ1jie.css\":\"0fd9465202f6dfceac29e67c17e5ac9fb1b7ba7615c1bb08782391b791d9f1e0\",\"assets/uPlot.esm-BScb58at.js\":\"068506d72590b07d0e53e012ff1541813c52c09bded848b3f97fcd1d4b0fd3b2\",\"favicon.ico\":\"eb66fde2ce87c9f33228184353f8a8c7ff0517cd76eaf9d6a94759bbd7276be9\",\"icon-192.png\":\"df4dde7d57f1963226b36d9501a3b173c02eddc858bef226ae0176dbb4b7ee19\",\"icon-512.png\":\"6e797a05bab65afa3472b6a2bbc42b2f7a33115ab789fa2403c592655657e04d\",\"icon-maskable.png\":\"98caea4e0138a5272161323354bea3585ecac298ff8576823258aeddee01a45f\",\"icon.svg\":\"d12d71c61b9b10bf6b04ba84d91497c272291cd0830c21d5ca98ce2c771fabf2\",\"index.html\":\"8fe5b92d18293debbbe75a073bfbae717a21d43f40be50716ca8077ef49cbd86\",\"page.webmanifest\":\"909a00587727949215a61974b50bfb8f15bda9c788e30bb4cdae5af19732dc86\"}");
/** What the page itself names: enough to say that the robot is away. */
const SHELL = JSON.parse("[\"index.html\",\"icon.svg\",\"icon-192.png\",\"page.webmanifest\",\"assets/index-DAU4znQf.js\",\"assets/parts-DMOWGIgI.js\",\"assets/index-DIAhJi-2.css\"]");
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
