// Keeps the page for a robot that is off or far: the files that it was built with, each checked by its digest, and nothing
// else. What the robot says is never kept. The build fills in the names.
const BUILD = "d44b8eadc61ebe5e";
/** @type {Record<string, string>} */
const FILES = JSON.parse("{\"assets/Behaviours-inOBYosZ.js\":\"9d87eac2c984613e1af080c06d4320fecbb1b694ee544e676ed771240febc1a4\",\"assets/Behaviours-ju1TH5lu.css\":\"7df80eb0fe64b2ebddd196abb60e688fe2d0c3fdb01c7e65492934acb953265b\",\"assets/Below-DD8QLG05.js\":\"1dad8aec7dfd5860cd5734dfdda02f15c797c332b639baa7414dc54fb1b87cea\",\"assets/Call-B5myZyvC.css\":\"9bd95ba7d1077c3c66775bc4757281e32365e5b943c7bc7624cd626d4792f397\",\"assets/Call-Bg5eBTUV.js\":\"316e141eef09b9633ff9d7a8969d9f789113fc2c33a1118afca4af4849c4077b\",\"assets/Display-CGVMX9HG.js\":\"47f0f97380fb9a368bfedd54daa26d0ab769f9a3e3664b44b00ceb12aebd0bc0\",\"assets/Display-NQ95WRFc.css\":\"7ac5d0b42865202760c3cc3fcdeb9f6aae740f24e27ee4d65c06575e4ae56193\",\"assets/Drive-BXh3BvDb.css\":\"cebbcfa50b8dd0c6a12580c3365a6917902b1b3462e54b1ccc4e554abc36d088\",\"assets/Drive-C2Q2H_Xx.js\":\"c002ee08b8b2c5ad14925c84f110ea178d3fbb60b09fd071a47f68570c309f4e\",\"assets/Joints-BhbOhD04.js\":\"95c61258b82b9ff90d6084638bc0c991fc208e2950de90afec41c748724cea91\",\"assets/Lacking-CacvYTQJ.css\":\"c7c4f4a3d3af03716a518f6da6ec94b34d1ffc67385869d3316d0f32ce4ddef3\",\"assets/Lacking-wsigxhNs.js\":\"640445a9d0af365cadb24f040f9d052cfae785b13f8cd4a1c50d5110365f05f9\",\"assets/Log-77P2CYS7.js\":\"1671cd6ae5663ae0044438de69d8e0410f7910d43b93f4b1144f8ed7d1291bbb\",\"assets/Motions-B1qlo88M.js\":\"ae3be897fde1e00fbfc227279e6c76e1ced221bee2db0ca112ed47604f7e4fca\",\"assets/Motions-CaFlTiXz.css\":\"3ae2ef57347e7e60dc54ae7e27f44ce213a22abdda941217da9332eb71385719\",\"assets/System-B9EPKRz2.js\":\"c95c12c9c2d6250daebefa1731d3d70ab5531271f874d2d84d5ad53e31eec816\",\"assets/System-DzGb0BSC.css\":\"24e170c69cd29e16f2088d6e853fad573a6835cf7d5736dadcb7954f3f03fb00\",\"assets/access-Dt3tEW4X.js\":\"1a714df6cc2858bd6881e3b39c8381ab6011d7e50c1f6809b1a3a738158aa8f6\",\"assets/connection-BdOcIF8P.js\":\"6b399688b105019cf66812c9e6010a6a1154fe0ba189c6117d32f5d4cf92fa57\",\"assets/data-DEdKjvrZ.js\":\"a8ffa5427d2446bc693c4340c2bd5dfb8165438a4764a38b79e9146df9980ce2\",\"assets/index-BCC0XYjs.js\":\"2624499dd6d0384a276f6117530e47e7d387b06a83ace156bede29199c145192\",\"assets/index-DrfhNA8_.css\":\"2a05279a6876bf121c01175a22aee496b2429adc0521a0755d636d146c10bdb3\",\"assets/manage-AT7TPFVa.js\":\"036d9c07eb8419f3156d27b1a1261d2d55d2a0f76688c80a578049864246f46b\",\"assets/model-B281qGni.js\":\"57f93a2b6599211e7510836ee39d32ed6b46f1f55cabf70f5884148f6909e870\",\"assets/model-BjR3jKsp.css\":\"e7b501306dc22d125bfd1c47dd9ad7e8822c5ccca5776778dd408da0b97061c5\",\"assets/news-CoDoh1zT.js\":\"edfeec9922a1844f9f2055637ee391bbb771b655b3058ee19252bab1b55266f2\",\"assets/parts-DusxjZzd.js\":\"a354ae462e7d5668638da305dc504d9cad9de29ca0c5acd4ad533b0aab166539\",\"assets/stage-BF6Bg5Jt.js\":\"dc7588bdb657f37fab047ec462d8f9293b0d5aace2e7ef9dc5d4d4f46d4a5c93\",\"assets/stream-cVYNvDsg.js\":\"b2beeee1fb2cb8d4112cdd179966fc2eb4be7a8b55292c4d1d048a3070e09680\",\"assets/uPlot-CnsZ1jie.css\":\"0fd9465202f6dfceac29e67c17e5ac9fb1b7ba7615c1bb08782391b791d9f1e0\",\"assets/uPlot.esm-BScb58at.js\":\"068506d72590b07d0e53e012ff1541813c52c09bded848b3f97fcd1d4b0fd3b2\",\"favicon.ico\":\"eb66fde2ce87c9f33228184353f8a8c7ff0517cd76eaf9d6a94759bbd7276be9\",\"icon-192.png\":\"df4dde7d57f1963226b36d9501a3b173c02eddc858bef226ae0176dbb4b7ee19\",\"icon-512.png\":\"6e797a05bab65afa3472b6a2bbc42b2f7a33115ab789fa2403c592655657e04d\",\"icon-maskable.png\":\"98caea4e0138a5272161323354bea3585ecac298ff8576823258aeddee01a45f\",\"icon.svg\":\"d12d71c61b9b10bf6b04ba84d91497c272291cd0830c21d5ca98ce2c771fabf2\",\"index.html\":\"b702b311ac4694874713c8d9b26f005122a77cfc67e6d36c1e640a467436b11b\",\"page.webmanifest\":\"909a00587727949215a61974b50bfb8f15bda9c788e30bb4cdae5af19732dc86\"}");
/** What the page itself names: enough to say that the robot is away. */
const SHELL = JSON.parse("[\"index.html\",\"icon.svg\",\"icon-192.png\",\"page.webmanifest\",\"assets/index-BCC0XYjs.js\",\"assets/access-Dt3tEW4X.js\",\"assets/parts-DusxjZzd.js\",\"assets/index-DrfhNA8_.css\"]");
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
