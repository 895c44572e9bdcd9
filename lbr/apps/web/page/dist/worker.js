// Keeps the page for a robot that is off or far: the files that it was built with, each checked by its digest, and nothing
// else. What the robot says is never kept. The build fills in the names.
const BUILD = "5ecccd107b654e75";
/** @type {Record<string, string>} */
const FILES = JSON.parse("{\"assets/Behaviours-QGWxMeD7.js\":\"c5f035df3c367077401c04101b9d1873810fa5dc0955bd2b6e70190ccd6fc6ae\",\"assets/Behaviours-ju1TH5lu.css\":\"7df80eb0fe64b2ebddd196abb60e688fe2d0c3fdb01c7e65492934acb953265b\",\"assets/Below-CfcKXC3P.js\":\"db07f4d89a103e5f7a5b2ebcdfaa4496692bc06c1b9e7bc637c66f29cf714748\",\"assets/Call-B5myZyvC.css\":\"9bd95ba7d1077c3c66775bc4757281e32365e5b943c7bc7624cd626d4792f397\",\"assets/Call-Cr6O0Jbl.js\":\"cd48f7a761f9865ad458742593988963eb6a52a3ad309e59b93c8bb715319b19\",\"assets/Display-CrYZ_Ttz.js\":\"e61cdc536b569af4b0f366779f0a5bd053be2cb6a9fadd65d8910ba03cd8e4b7\",\"assets/Display-NQ95WRFc.css\":\"7ac5d0b42865202760c3cc3fcdeb9f6aae740f24e27ee4d65c06575e4ae56193\",\"assets/Drive-BIQTvyto.js\":\"790b583221f5341ff7f4d4dfff152d3def6429d3fcd35258ca5bb88f28624343\",\"assets/Drive-DA0oOCw8.css\":\"ca725096dee8c5c674a829996b919b267320060c09db2b5ba6b10b2fc80d0083\",\"assets/Joints-LJ6bH_xz.js\":\"0abe8aa71d8152677216c169779ae66a52413cbf2612189ab4e36f66976f283d\",\"assets/Lacking-CacvYTQJ.css\":\"c7c4f4a3d3af03716a518f6da6ec94b34d1ffc67385869d3316d0f32ce4ddef3\",\"assets/Lacking-tuyV74-D.js\":\"e2e81699ef44b6050f3b342399c8c20c78d5e5afbd3d278ad33f265e78104ddc\",\"assets/Log-DvaIC4Ka.js\":\"053697a244c9be990d9fd5853baaea182a67a3e36e7db4b8de8d64a625155a1c\",\"assets/Motions-BtqMRO85.js\":\"73a392ff2cffc54071acc21854891638c0d444883bf84cf084c67bf5dffd505c\",\"assets/Motions-CaFlTiXz.css\":\"3ae2ef57347e7e60dc54ae7e27f44ce213a22abdda941217da9332eb71385719\",\"assets/System-DNz-RcWF.js\":\"9f326c42dec4a4e92e7bb7d5161e88e4529ecb2baaf94e01f04bce380e59623e\",\"assets/System-DzGb0BSC.css\":\"24e170c69cd29e16f2088d6e853fad573a6835cf7d5736dadcb7954f3f03fb00\",\"assets/access-BhzJ2x1u.js\":\"3d357cc3580107debc3795216cf8c95f7d1e061104c0e4c687d29cb87443ec88\",\"assets/connection-BlULrnFL.js\":\"c17294d64f0642ffaa2d6cf2164c23cc8e9683f9c274a16c026b22633ada09a0\",\"assets/data-CmycezHk.js\":\"febc8acaa3e57f83c072e1386a4537b4428e841d4cd107dac594e0c38f10587a\",\"assets/index-D94miYxF.js\":\"7949725e5f42d65c1d9d74d5a761fed1f4171a583d59becdb735dfea638e03b8\",\"assets/index-DrfhNA8_.css\":\"2a05279a6876bf121c01175a22aee496b2429adc0521a0755d636d146c10bdb3\",\"assets/manage-Dv2zamgt.js\":\"92249277c868d227b5f81829e72e37881cca3ab68d9d724da5e28fa1b14f34d8\",\"assets/model-BjR3jKsp.css\":\"e7b501306dc22d125bfd1c47dd9ad7e8822c5ccca5776778dd408da0b97061c5\",\"assets/model-v9dwak50.js\":\"d030f381f5ad569ed6ce8a1d6d8aca1526db7ec0c81f422c1d681d2e043e5666\",\"assets/news-Bgzfollq.js\":\"915ccebaebe1a1f6f80921c4d8f5acc7e00a99d411c7503ed46e0108453f3f68\",\"assets/stage-CsFc0WkF.js\":\"d62a93996f635eb0ce7b7ea206970b028b7aac022cfdb67e960e978f11d59f0a\",\"assets/stream-C3G-Ha-n.js\":\"cf496f42b966b8baa5079c1017fb5cff2cbddc4e5034d06dba8fd145742b3fd0\",\"assets/uPlot-CnsZ1jie.css\":\"0fd9465202f6dfceac29e67c17e5ac9fb1b7ba7615c1bb08782391b791d9f1e0\",\"assets/uPlot.esm-BScb58at.js\":\"068506d72590b07d0e53e012ff1541813c52c09bded848b3f97fcd1d4b0fd3b2\",\"favicon.ico\":\"eb66fde2ce87c9f33228184353f8a8c7ff0517cd76eaf9d6a94759bbd7276be9\",\"icon-192.png\":\"df4dde7d57f1963226b36d9501a3b173c02eddc858bef226ae0176dbb4b7ee19\",\"icon-512.png\":\"6e797a05bab65afa3472b6a2bbc42b2f7a33115ab789fa2403c592655657e04d\",\"icon-maskable.png\":\"98caea4e0138a5272161323354bea3585ecac298ff8576823258aeddee01a45f\",\"icon.svg\":\"d12d71c61b9b10bf6b04ba84d91497c272291cd0830c21d5ca98ce2c771fabf2\",\"index.html\":\"4dc61e66bb39350eec558cd5c4d62b2fbe537c464f966cedea1f02cad02e62a9\",\"page.webmanifest\":\"909a00587727949215a61974b50bfb8f15bda9c788e30bb4cdae5af19732dc86\"}");
/** What the page itself names: enough to say that the robot is away. */
const SHELL = JSON.parse("[\"index.html\",\"icon.svg\",\"icon-192.png\",\"page.webmanifest\",\"assets/index-D94miYxF.js\",\"assets/access-BhzJ2x1u.js\",\"assets/index-DrfhNA8_.css\"]");
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
