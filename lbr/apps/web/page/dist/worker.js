// Keeps the page for a robot that is off or far: the files that it was built with, each checked by its digest, and nothing
// else. What the robot says is never kept. The build fills in the names.
const BUILD = "5ba5c317fa4672fd";
/** @type {Record<string, string>} */
const FILES = JSON.parse("{\"assets/Behaviours-BqZY5irQ.js\":\"38360288fc1c28609b07ecc33e04245c60d2178517f08301dc3b7536b563b4aa\",\"assets/Behaviours-ju1TH5lu.css\":\"7df80eb0fe64b2ebddd196abb60e688fe2d0c3fdb01c7e65492934acb953265b\",\"assets/Below-qSKAkQ4G.js\":\"39e37d63c2f62a4c244127748279b304a7bf344f1932adf1cb3d33a46a427fb0\",\"assets/Call-2Us354tm.js\":\"08389fbef641d4f1e52e839f340a7e1d3ab86e556558b304fba366fa2d255047\",\"assets/Call-B5myZyvC.css\":\"9bd95ba7d1077c3c66775bc4757281e32365e5b943c7bc7624cd626d4792f397\",\"assets/Display-BZFbaRP8.js\":\"c771043bf8715034129a03aece2bc3bdbc9bee8f0f00fc713383044963dfb8b2\",\"assets/Display-hbDRwTTd.css\":\"c83eeecb550859a06b9cd577a58e8c226d9ef24d37e0f7fb05ec1f901b52e67e\",\"assets/Drive-BNhw9IVs.js\":\"590bb9d53b3f16e1b3e3117a9314c35f7ed59af050ee51182f6337b2dc5a2530\",\"assets/Drive-DA0oOCw8.css\":\"ca725096dee8c5c674a829996b919b267320060c09db2b5ba6b10b2fc80d0083\",\"assets/Joints-CbD4lJvs.js\":\"1ca11fceb172da15a34b58c2c2e5aabb4be4aac24967add23c50471f4bf673f4\",\"assets/Lacking-CacvYTQJ.css\":\"c7c4f4a3d3af03716a518f6da6ec94b34d1ffc67385869d3316d0f32ce4ddef3\",\"assets/Lacking-SWEJFHse.js\":\"305fe4858c60846327cadf074ac7d7becc4fc6e89caae8d81f7c8ecff3a97cf1\",\"assets/Log-D9K4oV3P.js\":\"8b80a78daba1952ac2766bba83ae62dc7fd88cbfab01c5eb96388c02491da8da\",\"assets/Motions-CQi7vXrG.js\":\"af894f2989ff87e0eba3e126ace107465c5e6c1e82eba2c3c2e922424bd0cefd\",\"assets/Motions-CaFlTiXz.css\":\"3ae2ef57347e7e60dc54ae7e27f44ce213a22abdda941217da9332eb71385719\",\"assets/System-DmHbGFS5.js\":\"9d25d94f789f4332fae637bd8c3dabc19d534575381d9103bbb31cbc71958e91\",\"assets/System-DzGb0BSC.css\":\"24e170c69cd29e16f2088d6e853fad573a6835cf7d5736dadcb7954f3f03fb00\",\"assets/access-CFDUfALU.js\":\"a42f8d4ff92015e35dd4a2f5e757bd56cfaf94c62d95e5541e31403f0dfbbd3c\",\"assets/connection-B2FztIg9.js\":\"d778ef904d808d2ab045ddf308a2e9df2eef4ca9d85aa5bdfbb969c4ec4cde1c\",\"assets/data-DYL9Yizt.js\":\"5a84d32374038de82f5bef5952af4665639f9b37c5a3cdcb08b1c109781e6660\",\"assets/index-BU4BEjjH.js\":\"7ea072f94278089b6797e3179d43947b63b2d5a249978f93207fea52bb5ad542\",\"assets/index-DrfhNA8_.css\":\"2a05279a6876bf121c01175a22aee496b2429adc0521a0755d636d146c10bdb3\",\"assets/manage-pu6pKFrc.js\":\"a8ed60ffe317f2dff42fc862f0e58a52086e67ac0b3a4aabdfd0fab3aff53d38\",\"assets/model-BjR3jKsp.css\":\"e7b501306dc22d125bfd1c47dd9ad7e8822c5ccca5776778dd408da0b97061c5\",\"assets/model-Bm18qZ_h.js\":\"ad691f0f0f26b6ec6536fb7ee66017bf60b6ca2843e437d20dd2f19cd6f88d64\",\"assets/news-IB3hRtIX.js\":\"a9d3753cc794e1fbdc9523b95e5b668a55cf3e4097bfff50c9b36fb04d8ce37d\",\"assets/parts-RopjkLsN.js\":\"4a28c5eca626d7dda3105e91ddc3ab91d10ae2d1191d9e1737ce13c583144395\",\"assets/stage-CfOM6q9A.js\":\"c499a30ca440e4393707f9e0d46a45eb7f0d730c6f8463b94114b7898127a8cf\",\"assets/stream-BKK0-M2o.js\":\"61f465cd017410af6397ff85a804ea958ee71bebcf8377e081b0d438d5468327\",\"assets/uPlot-CnsZ1jie.css\":\"0fd9465202f6dfceac29e67c17e5ac9fb1b7ba7615c1bb08782391b791d9f1e0\",\"assets/uPlot.esm-BScb58at.js\":\"068506d72590b07d0e53e012ff1541813c52c09bded848b3f97fcd1d4b0fd3b2\",\"favicon.ico\":\"eb66fde2ce87c9f33228184353f8a8c7ff0517cd76eaf9d6a94759bbd7276be9\",\"icon-192.png\":\"df4dde7d57f1963226b36d9501a3b173c02eddc858bef226ae0176dbb4b7ee19\",\"icon-512.png\":\"6e797a05bab65afa3472b6a2bbc42b2f7a33115ab789fa2403c592655657e04d\",\"icon-maskable.png\":\"98caea4e0138a5272161323354bea3585ecac298ff8576823258aeddee01a45f\",\"icon.svg\":\"d12d71c61b9b10bf6b04ba84d91497c272291cd0830c21d5ca98ce2c771fabf2\",\"index.html\":\"53977298269093e67ad58c7a3b53ac642acea5ed7dfd005272a19781ea012fa5\",\"page.webmanifest\":\"909a00587727949215a61974b50bfb8f15bda9c788e30bb4cdae5af19732dc86\"}");
/** What the page itself names: enough to say that the robot is away. */
const SHELL = JSON.parse("[\"index.html\",\"icon.svg\",\"icon-192.png\",\"page.webmanifest\",\"assets/index-BU4BEjjH.js\",\"assets/access-CFDUfALU.js\",\"assets/parts-RopjkLsN.js\",\"assets/index-DrfhNA8_.css\"]");
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
