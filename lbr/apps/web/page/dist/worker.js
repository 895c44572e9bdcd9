// Keeps the page for a robot that is off or far: the files that it was built with, each checked by its digest, and nothing
// else. What the robot says is never kept. The build fills in the names.
const BUILD = "0d1fd70bb87d36e6";
/** @type {Record<string, string>} */
const FILES = JSON.parse("{\"assets/Behaviours-COQiCrH4.js\":\"9f8514966262a39378868818ff917d5ee664fc4f8791197ab57d368478bb60ed\",\"assets/Behaviours-ju1TH5lu.css\":\"7df80eb0fe64b2ebddd196abb60e688fe2d0c3fdb01c7e65492934acb953265b\",\"assets/Below-CeGJdv6-.js\":\"f7e1bf23d96b8dda2e2abec640f322ed39a1fb9f3b1b39f2f4d6f7885c547fa9\",\"assets/Call-B5myZyvC.css\":\"9bd95ba7d1077c3c66775bc4757281e32365e5b943c7bc7624cd626d4792f397\",\"assets/Call-B_S9ikW6.js\":\"9cdcd8ea52d568e2960dae3d733206e0eb81b51e07408a472252e158c82b8afa\",\"assets/Display-9Y79vpxV.js\":\"24eb75887c47b1544e006ff343564aeedce60e84b68a2ca7dd258675ab074556\",\"assets/Display-NQ95WRFc.css\":\"7ac5d0b42865202760c3cc3fcdeb9f6aae740f24e27ee4d65c06575e4ae56193\",\"assets/Drive-DA0oOCw8.css\":\"ca725096dee8c5c674a829996b919b267320060c09db2b5ba6b10b2fc80d0083\",\"assets/Drive-DUCYME-H.js\":\"c8c5d45e97e3334a7b0d4ea9072b5b73e71881357c8e1c28f44fdae49db82bd0\",\"assets/Joints-C9eOLXU_.js\":\"4ae667cad66426b5f14ab46d653dca0616f71048237c5011ea60d03f6afaf5cb\",\"assets/Lacking-Br1ANOFa.js\":\"26f67807370e6b549201d86806b36da1ae97cec8df84acc2fa02e6c4265b8764\",\"assets/Lacking-CacvYTQJ.css\":\"c7c4f4a3d3af03716a518f6da6ec94b34d1ffc67385869d3316d0f32ce4ddef3\",\"assets/Log-DnuJVrDl.js\":\"3baa431875d8f67a902cf4711e8308078384f1a37680779f1220978a14028812\",\"assets/Motions-CaFlTiXz.css\":\"3ae2ef57347e7e60dc54ae7e27f44ce213a22abdda941217da9332eb71385719\",\"assets/Motions-CbDxU52e.js\":\"9f73adf0d103b2a0ed1f8380c3f78ec967525b96eb04dfa7c02a524baf6f77c5\",\"assets/System-Cxv8z1XF.js\":\"70f8a6cab328f3f4a7088e19ddaa7933a4a762217a9e076a0301fd6226f9cb3c\",\"assets/System-DzGb0BSC.css\":\"24e170c69cd29e16f2088d6e853fad573a6835cf7d5736dadcb7954f3f03fb00\",\"assets/access-BhzJ2x1u.js\":\"3d357cc3580107debc3795216cf8c95f7d1e061104c0e4c687d29cb87443ec88\",\"assets/connection-BlULrnFL.js\":\"c17294d64f0642ffaa2d6cf2164c23cc8e9683f9c274a16c026b22633ada09a0\",\"assets/data-DhJNu2mv.js\":\"686fdcc123dcc414685b44f7abdf6bf02e12eaf5a7b8c52665a1a93e8fbc75ea\",\"assets/index-BieW2Src.js\":\"ec874054e42601eaf323bedc52c123b42042506db6409928713cea53b7e44eec\",\"assets/index-DrfhNA8_.css\":\"2a05279a6876bf121c01175a22aee496b2429adc0521a0755d636d146c10bdb3\",\"assets/manage-B9q6iwaY.js\":\"b817b2b28674e8f4dd780acb333b702f9c6f6a03c3481004cdf445e2001168e6\",\"assets/model-BjR3jKsp.css\":\"e7b501306dc22d125bfd1c47dd9ad7e8822c5ccca5776778dd408da0b97061c5\",\"assets/model-D0sl0I0x.js\":\"308977379c27034e7436d7691f83ef96c55700f6a06df4e0a9c78447a6f3cc81\",\"assets/news-CjXFFE3g.js\":\"a2c44d87301a32569532f44ab6b9ea2234c1a7e1c4de0cf3fa2707343537e62a\",\"assets/stage-BN5Wu6if.js\":\"5b58a674c15203219200c76f6e9c72007934ab55864aabdd0da5f65fe8b89a2f\",\"assets/stream-Cg7MB9he.js\":\"a9a1aa3765997743c99e9753d8813c650d8b174330f5230ba02e54f70248cfed\",\"assets/uPlot-CnsZ1jie.css\":\"0fd9465202f6dfceac29e67c17e5ac9fb1b7ba7615c1bb08782391b791d9f1e0\",\"assets/uPlot.esm-BScb58at.js\":\"068506d72590b07d0e53e012ff1541813c52c09bded848b3f97fcd1d4b0fd3b2\",\"favicon.ico\":\"eb66fde2ce87c9f33228184353f8a8c7ff0517cd76eaf9d6a94759bbd7276be9\",\"icon-192.png\":\"df4dde7d57f1963226b36d9501a3b173c02eddc858bef226ae0176dbb4b7ee19\",\"icon-512.png\":\"6e797a05bab65afa3472b6a2bbc42b2f7a33115ab789fa2403c592655657e04d\",\"icon-maskable.png\":\"98caea4e0138a5272161323354bea3585ecac298ff8576823258aeddee01a45f\",\"icon.svg\":\"d12d71c61b9b10bf6b04ba84d91497c272291cd0830c21d5ca98ce2c771fabf2\",\"index.html\":\"14e598e04463295497cc9f5b323d13768ba3d98a57ef05ad035d844806b5f39e\",\"page.webmanifest\":\"909a00587727949215a61974b50bfb8f15bda9c788e30bb4cdae5af19732dc86\"}");
/** What the page itself names: enough to say that the robot is away. */
const SHELL = JSON.parse("[\"index.html\",\"icon.svg\",\"icon-192.png\",\"page.webmanifest\",\"assets/index-BieW2Src.js\",\"assets/access-BhzJ2x1u.js\",\"assets/index-DrfhNA8_.css\"]");
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
