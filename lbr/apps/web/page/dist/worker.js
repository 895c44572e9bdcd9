// Keeps the page for a robot that is off or far: the files that it was built with, each checked by its digest, and nothing
// else. What the robot says is never kept. The build fills in the names.
const BUILD = "1a2e160be2a8c2d5";
/** @type {Record<string, string>} */
const FILES = JSON.parse("{\"assets/Behaviours-CW6UGM9H.css\":\"f8ec05f55e6ffeb2c0ecf622c8f86b9bcd1e9fc4197c1fb4ed8135c322d9d1a4\",\"assets/Behaviours-xJaef5pd.js\":\"892860242040dee3955abc9030dea3abc3f310eddd096fb270a1176f8742e1e1\",\"assets/Call-BH-FlvRt.css\":\"72c27a044611bd5e73568c62521730576fefce8c2a7bc35fb38ab268f89da215\",\"assets/Call-CeSJzT92.js\":\"859f97c4252a68f141e542da0146e4333ada29584274e6c15339e4452f8e3b5c\",\"assets/Display-eUjWClXE.js\":\"57d7b9c4e1f75b80d85f70921fa564f760c753130aa509c86c831c82e6e098fe\",\"assets/Display-hbDRwTTd.css\":\"c83eeecb550859a06b9cd577a58e8c226d9ef24d37e0f7fb05ec1f901b52e67e\",\"assets/Drive-C8Tq45Zd.css\":\"08011867db62c8cb3b9c12a4042ef6bb9ec597d6a95f74b6b314a7d790941e10\",\"assets/Drive-CX7Z0szz.js\":\"fa05636f0701c3733cda99507ccd9aa25a2e862c88650ea58c62db5936222c5f\",\"assets/Joints-BiyLNPrd.js\":\"d5472dca30cdc86ce0fa525443c228757c51cadabf41b92374f022287ffe8b2d\",\"assets/Motions-CoUeG6QQ.css\":\"c7405ed80447ef97051d5de59d8b24ad9cce70b4956e89b2333a1e4c142f4c38\",\"assets/Motions-DNXGjcJ1.js\":\"3c0e9efbad8b3e0955cd19ffa910779e52ca61a0236febd94ac131c7868740dd\",\"assets/System-BDMkh0Pj.css\":\"dca6381a388a05891f8336a3598826d177e566ee4177ebae92ec4f1021f35493\",\"assets/System-BZ5N8Y_o.js\":\"3fbf41ed0a5db6a42b1f8c8b9cedb818df4796c103ccbec5603546d708541c76\",\"assets/index-IhelOE6j.css\":\"640a987a481e2335580a34fdb55c786ddbb0c46958371a79c8de724ead2e4ce3\",\"assets/index-jEUHyfw7.js\":\"18c8013b65054826db5933cac62629db0e4d0c618121a579dc0726038e9308b3\",\"assets/manage-DEB-bAUN.js\":\"76b74300e85432635d03aa67dcf85c406a589751ee306655f4381d7efecd2c8b\",\"assets/model-Bx7yEgVu.css\":\"802b384b1a54f70974f60851ef6bb609817b19f6c569ccb15816cb9f8a7b4e9f\",\"assets/model-n2VD2n1U.js\":\"fd4e92ed804f5b43a508493f3b5d5ab715fa37d0485bf9ceb0486860adbbe61d\",\"assets/news-DE7neGRE.js\":\"1402ba8f92a41a80e811d5f44c5041a4fc75a49d60eaf78a8a6743e676ae4562\",\"assets/parts-CToa_OeG.js\":\"5fd4bad4c94c5c4873bf5d904c090fa7b168748a1e74d1fb2e3a541b59247fef\",\"assets/saving-DbPjuOQb.js\":\"94d1a2e76767f7fdfe2e444b94c2326a340904bc4ede0b5445dbbf7236821d66\",\"assets/stage-auYB5hVi.js\":\"ddea6783ca449822902db1613a7b99ab47393374e7a42c1f3f70a5b3486737dd\",\"assets/stream-ouzns1mR.js\":\"16b7f138130fcf9fccc405b5a27a1618785db107c2264c1a05f7b927fb4a40be\",\"assets/uPlot-CnsZ1jie.css\":\"0fd9465202f6dfceac29e67c17e5ac9fb1b7ba7615c1bb08782391b791d9f1e0\",\"assets/uPlot.esm-BScb58at.js\":\"068506d72590b07d0e53e012ff1541813c52c09bded848b3f97fcd1d4b0fd3b2\",\"favicon.ico\":\"eb66fde2ce87c9f33228184353f8a8c7ff0517cd76eaf9d6a94759bbd7276be9\",\"icon-192.png\":\"df4dde7d57f1963226b36d9501a3b173c02eddc858bef226ae0176dbb4b7ee19\",\"icon-512.png\":\"6e797a05bab65afa3472b6a2bbc42b2f7a33115ab789fa2403c592655657e04d\",\"icon-maskable.png\":\"98caea4e0138a5272161323354bea3585ecac298ff8576823258aeddee01a45f\",\"icon.svg\":\"d12d71c61b9b10bf6b04ba84d91497c272291cd0830c21d5ca98ce2c771fabf2\",\"index.html\":\"0fa3c511c6fa2c690d7d7342f4f4da16aec50a750a403d11ce0eeaa4089176c5\",\"page.webmanifest\":\"909a00587727949215a61974b50bfb8f15bda9c788e30bb4cdae5af19732dc86\"}");
/** What the page itself names: enough to say that the robot is away. */
const SHELL = JSON.parse("[\"index.html\",\"icon.svg\",\"icon-192.png\",\"page.webmanifest\",\"assets/index-jEUHyfw7.js\",\"assets/parts-CToa_OeG.js\",\"assets/index-IhelOE6j.css\"]");
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
