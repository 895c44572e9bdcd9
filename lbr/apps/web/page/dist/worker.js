// Keeps the page for a robot that is off or far: the files that it was built with, each checked by its digest, and nothing
// else. What the robot says is never kept. The build fills in the names.
const BUILD = "fbb7c9e5c2f1b7b2";
/** @type {Record<string, string>} */
const FILES = JSON.parse("{\"assets/Behaviours-CIxuMHje.js\":\"2e7a4a6a1a2905ece4f0109574a674f8dff28ff7785d76dd5e331ada1a7512db\",\"assets/Behaviours-CW6UGM9H.css\":\"f8ec05f55e6ffeb2c0ecf622c8f86b9bcd1e9fc4197c1fb4ed8135c322d9d1a4\",\"assets/Call-BH-FlvRt.css\":\"72c27a044611bd5e73568c62521730576fefce8c2a7bc35fb38ab268f89da215\",\"assets/Call-KfNqzBac.js\":\"5322fff15340db2b57a181e3e57f996f54e3f862eacd92e34dbb3cb033bd0025\",\"assets/Display-hbDRwTTd.css\":\"c83eeecb550859a06b9cd577a58e8c226d9ef24d37e0f7fb05ec1f901b52e67e\",\"assets/Display-kuI9DloB.js\":\"9fa421b9b210ad67f26adcbd78a64271496736e8fdb2dc1f7ac7c2563cd62c3a\",\"assets/Drive-C8Tq45Zd.css\":\"08011867db62c8cb3b9c12a4042ef6bb9ec597d6a95f74b6b314a7d790941e10\",\"assets/Drive-Cecc8QgK.js\":\"213c74a24d342d2103395168bb0f2a2dff4c6c49726a9f9b22d1cc461ae122a3\",\"assets/Joints-mzV0jQx-.js\":\"2aca3ed21515abc95800c9ae9f5d268b53cf6e1b66e0686f8755100faf717679\",\"assets/Motions-B_57coZe.js\":\"8763cf015570c895e1c9802fae90b2011a6eb48c60a1f1bf8969d9e594bf56a6\",\"assets/Motions-CoUeG6QQ.css\":\"c7405ed80447ef97051d5de59d8b24ad9cce70b4956e89b2333a1e4c142f4c38\",\"assets/System-BDMkh0Pj.css\":\"dca6381a388a05891f8336a3598826d177e566ee4177ebae92ec4f1021f35493\",\"assets/System-Dmwb1AWD.js\":\"15bcf105bf271bccb005b537e94b1aaf2bb15588b779f722819575d3b3d1df6b\",\"assets/index-B8I2Xawt.js\":\"53b18839b5849082598fd1b831b1a175b2f7bab22121e98739593e16c86bfc47\",\"assets/index-IhelOE6j.css\":\"640a987a481e2335580a34fdb55c786ddbb0c46958371a79c8de724ead2e4ce3\",\"assets/manage-BxJROtyc.js\":\"665677ed4fe8a461cadec37ddfc1368514993304e723dfd6ffc094cd00d8a564\",\"assets/model-Bx7yEgVu.css\":\"802b384b1a54f70974f60851ef6bb609817b19f6c569ccb15816cb9f8a7b4e9f\",\"assets/model-CD2GEM2r.js\":\"cb77572832b3edbfeed4c8e2a7e6e22f7e0994e2ec4ff57a9f7a56db3924f0a5\",\"assets/news-B7jE4Ayv.js\":\"bd7b92f2b92b59aa4c779f1cdd145ee8b2f69c917b54d3267f1af99d2d4f33c5\",\"assets/parts-C3F7BxJ9.js\":\"d05d7d3a8a2de0201a6e4ae28ca4eb5f57631c201a8eb0c51498d776f3768c81\",\"assets/saving-DbPjuOQb.js\":\"94d1a2e76767f7fdfe2e444b94c2326a340904bc4ede0b5445dbbf7236821d66\",\"assets/stage-BlbHbBTT.js\":\"0ae2816c53daec68d69f9ec0acac246eb1755d7389d75e550a8acf8b471e648e\",\"assets/stream-BoIIO0P5.js\":\"c6820c4a73ba0fca64fa5c994145e63cc418c2f2af95342f535b9edd08e548c0\",\"assets/uPlot-CnsZ1jie.css\":\"0fd9465202f6dfceac29e67c17e5ac9fb1b7ba7615c1bb08782391b791d9f1e0\",\"assets/uPlot.esm-BScb58at.js\":\"068506d72590b07d0e53e012ff1541813c52c09bded848b3f97fcd1d4b0fd3b2\",\"favicon.ico\":\"eb66fde2ce87c9f33228184353f8a8c7ff0517cd76eaf9d6a94759bbd7276be9\",\"icon-192.png\":\"df4dde7d57f1963226b36d9501a3b173c02eddc858bef226ae0176dbb4b7ee19\",\"icon-512.png\":\"6e797a05bab65afa3472b6a2bbc42b2f7a33115ab789fa2403c592655657e04d\",\"icon-maskable.png\":\"98caea4e0138a5272161323354bea3585ecac298ff8576823258aeddee01a45f\",\"icon.svg\":\"d12d71c61b9b10bf6b04ba84d91497c272291cd0830c21d5ca98ce2c771fabf2\",\"index.html\":\"2192a37fd6c38a44e561d8fb52082d23403d905b156e97d42e3aeffe32d7e737\",\"page.webmanifest\":\"909a00587727949215a61974b50bfb8f15bda9c788e30bb4cdae5af19732dc86\"}");
/** What the page itself names: enough to say that the robot is away. */
const SHELL = JSON.parse("[\"index.html\",\"icon.svg\",\"icon-192.png\",\"page.webmanifest\",\"assets/index-B8I2Xawt.js\",\"assets/parts-C3F7BxJ9.js\",\"assets/index-IhelOE6j.css\"]");
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
