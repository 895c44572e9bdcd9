// Keeps the page for a robot that is off or far: the files that it was built with, each checked by its digest, and nothing
// else. What the robot says is never kept. The build fills in the names.
const BUILD = "bf015ee33e5bb37c";
/** @type {Record<string, string>} */
const FILES = JSON.parse("{\"assets/Behaviours-CSNbkWjd.js\":\"0ee71cd53915e49db215f7e0202a2dcc31230771d8f2cd7fd5e54ba87e241490\",\"assets/Behaviours-ju1TH5lu.css\":\"7df80eb0fe64b2ebddd196abb60e688fe2d0c3fdb01c7e65492934acb953265b\",\"assets/Below-DXtfluY7.js\":\"8890475dced79289a9ff5b73c3d517747244044fbb834b3e8ff08e14aa835d73\",\"assets/Call-B5myZyvC.css\":\"9bd95ba7d1077c3c66775bc4757281e32365e5b943c7bc7624cd626d4792f397\",\"assets/Call-CTER_xV8.js\":\"567a97705b6193d071f1e573606cb3f3cef2a8fd91212ea7e29841dd89b57834\",\"assets/Display-NQ95WRFc.css\":\"7ac5d0b42865202760c3cc3fcdeb9f6aae740f24e27ee4d65c06575e4ae56193\",\"assets/Display-i72HG0I3.js\":\"ab08ffd872ddc5301e358d29d9eda2f7b88bf0caa93eccde2995f2b08d78b31d\",\"assets/Drive-BXh3BvDb.css\":\"cebbcfa50b8dd0c6a12580c3365a6917902b1b3462e54b1ccc4e554abc36d088\",\"assets/Drive-DPqAdGHB.js\":\"d467582d2b8821a79945c4d354bfafbd85267fc20e5bc51e9cc007a5506d8e01\",\"assets/Joints-WBdQOnn1.js\":\"f030b2958d203eff5110903d9708d068250963feac0a8be1ac61ab5278811980\",\"assets/Lacking-CacvYTQJ.css\":\"c7c4f4a3d3af03716a518f6da6ec94b34d1ffc67385869d3316d0f32ce4ddef3\",\"assets/Lacking-DWSGc6zS.js\":\"57c7802d675e2018fa40f175f1cc2b9c21288006bc402fa0c6003d95d50a923d\",\"assets/Log-RC_lka7y.js\":\"ce4467abe88ddd55e82af704f53c50631c9f36ec191af036705da0496f1e427f\",\"assets/Motions-C987w1fB.js\":\"2a1c4492bbe824fdfed3a155d50d07cf35399b024ea4230e8e64d2b56b3e49c4\",\"assets/Motions-CaFlTiXz.css\":\"3ae2ef57347e7e60dc54ae7e27f44ce213a22abdda941217da9332eb71385719\",\"assets/System-7w3CV9rk.js\":\"633ead39f4c8828b876c7612d0cc4a4fcdde8ee81ed152abee2e8dcd57689e83\",\"assets/System-DzGb0BSC.css\":\"24e170c69cd29e16f2088d6e853fad573a6835cf7d5736dadcb7954f3f03fb00\",\"assets/access-Dt3tEW4X.js\":\"1a714df6cc2858bd6881e3b39c8381ab6011d7e50c1f6809b1a3a738158aa8f6\",\"assets/connection-BdOcIF8P.js\":\"6b399688b105019cf66812c9e6010a6a1154fe0ba189c6117d32f5d4cf92fa57\",\"assets/data-Copouydw.js\":\"3cd8c879c39d03a93c5fee5c5137b0716f4583404b439b43c1d5c02a53f806c7\",\"assets/index-CJg31BZV.js\":\"82e19a3b3fc3af0d8fc5054a8528600363418e3b5fbbbb45419fc2f943743447\",\"assets/index-DrfhNA8_.css\":\"2a05279a6876bf121c01175a22aee496b2429adc0521a0755d636d146c10bdb3\",\"assets/manage-DIyhYtt3.js\":\"1307532e1cf8ac02a65850929f6b53ae37bc653a1e7d8968eb82a5e384bf3da4\",\"assets/model-BZE5jwAJ.js\":\"d218eb6d343533e6206d855653f2c40fa9c32e4d849c369037bc8cb5e82035da\",\"assets/model-BjR3jKsp.css\":\"e7b501306dc22d125bfd1c47dd9ad7e8822c5ccca5776778dd408da0b97061c5\",\"assets/news-hAZeGv6Q.js\":\"a1e8684a62bb60dd751d266530a8b1ad7c27f64a57ecc3f912e3b9b6e1f90a9e\",\"assets/parts-D4gSPHAK.js\":\"1ca3213bc1cd9d755603814e3c0d9e67d94485e673f2aaf8d64eb4f99ac06814\",\"assets/stage-D3gbR6xg.js\":\"70abde9727373dc478e344e1014aa61fd6e91498f67efadcc7ff36c27bf0ce35\",\"assets/stream-jyRuNq-C.js\":\"b4a38705609f1798d62828e4d747491d08aa5155900430de4d6e1c98379a59b4\",\"assets/uPlot-CnsZ1jie.css\":\"0fd9465202f6dfceac29e67c17e5ac9fb1b7ba7615c1bb08782391b791d9f1e0\",\"assets/uPlot.esm-BScb58at.js\":\"068506d72590b07d0e53e012ff1541813c52c09bded848b3f97fcd1d4b0fd3b2\",\"favicon.ico\":\"eb66fde2ce87c9f33228184353f8a8c7ff0517cd76eaf9d6a94759bbd7276be9\",\"icon-192.png\":\"df4dde7d57f1963226b36d9501a3b173c02eddc858bef226ae0176dbb4b7ee19\",\"icon-512.png\":\"6e797a05bab65afa3472b6a2bbc42b2f7a33115ab789fa2403c592655657e04d\",\"icon-maskable.png\":\"98caea4e0138a5272161323354bea3585ecac298ff8576823258aeddee01a45f\",\"icon.svg\":\"d12d71c61b9b10bf6b04ba84d91497c272291cd0830c21d5ca98ce2c771fabf2\",\"index.html\":\"30d9b88285a02cbd1cb52075f07100bb23a105167d23f709b11bd6a79fa9678e\",\"page.webmanifest\":\"909a00587727949215a61974b50bfb8f15bda9c788e30bb4cdae5af19732dc86\"}");
/** What the page itself names: enough to say that the robot is away. */
const SHELL = JSON.parse("[\"index.html\",\"icon.svg\",\"icon-192.png\",\"page.webmanifest\",\"assets/index-CJg31BZV.js\",\"assets/access-Dt3tEW4X.js\",\"assets/parts-D4gSPHAK.js\",\"assets/index-DrfhNA8_.css\"]");
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
