// Keeps the page for a robot that is off or far: the files that it was built with, each checked by its digest, and nothing
// else. What the robot says is never kept. The build fills in the names.
const BUILD = "5e7364e442635f8a";
/** @type {Record<string, string>} */
const FILES = JSON.parse("{\"assets/Behaviours-aj6lKh2B.js\":\"e623267c3713c27ce345d8ae5c618a612262a0c8273248c6554e0fe5576f5d33\",\"assets/Behaviours-ju1TH5lu.css\":\"7df80eb0fe64b2ebddd196abb60e688fe2d0c3fdb01c7e65492934acb953265b\",\"assets/Below-dnr8l5Xo.js\":\"de688c7401384dc69885cdb1aadfa5357017c13a651f0e86f1466ae1707894bb\",\"assets/Call-B5myZyvC.css\":\"9bd95ba7d1077c3c66775bc4757281e32365e5b943c7bc7624cd626d4792f397\",\"assets/Call-BYoLrWih.js\":\"e9efde59b257ad1d1af7fcfc2c5342bb5b97440825a4d10be7a1f6d31906ebd9\",\"assets/Display-EjNGcswN.js\":\"490d1c39c1153d190ea43dbb715dccb6e71f19a727640bba383ac7df089d9a81\",\"assets/Display-hbDRwTTd.css\":\"c83eeecb550859a06b9cd577a58e8c226d9ef24d37e0f7fb05ec1f901b52e67e\",\"assets/Drive-DA0oOCw8.css\":\"ca725096dee8c5c674a829996b919b267320060c09db2b5ba6b10b2fc80d0083\",\"assets/Drive-uz3iZQcx.js\":\"a6feaac47250c4b2a142bbc31710aa942078b7dd96e7e782fea790d39eccf029\",\"assets/Joints-Ba-619SG.js\":\"01f23defd58bdd3c3a227774b76de6995e7fac47b00a9fd30e9d18b44f6edf53\",\"assets/Lacking-C9ETlHef.js\":\"17925905ff781911e35b97a2ce1313c9795df202925498f582bdec90393261b8\",\"assets/Lacking-CacvYTQJ.css\":\"c7c4f4a3d3af03716a518f6da6ec94b34d1ffc67385869d3316d0f32ce4ddef3\",\"assets/Log-B9tZJRhK.js\":\"5de9ef2c5d579b1640f7ff78ac35c962e46a0a06937f4c42f20f39d47983b0d0\",\"assets/Motions-CaFlTiXz.css\":\"3ae2ef57347e7e60dc54ae7e27f44ce213a22abdda941217da9332eb71385719\",\"assets/Motions-DU1_eBzh.js\":\"1228249b8ee88841799f884ccf69efae511db081cda5b7801999e9b4ae581412\",\"assets/System-DzGb0BSC.css\":\"24e170c69cd29e16f2088d6e853fad573a6835cf7d5736dadcb7954f3f03fb00\",\"assets/System-uXcaglsN.js\":\"f4b44c0ad2aad44202af84032bbbbd112e607c0b5e82fea14889dacd7a23f5f5\",\"assets/access-3cI6PH5L.js\":\"cb8a903691d463f52eac78e36d329ade64aa49dfce63b9c97cb93834388bc2ff\",\"assets/connection-BMeTVRAf.js\":\"430a0cd0a016f95e0773341c8a7c7a1c6104cb06e2a8021d10d05066efe9ab7c\",\"assets/data-BZEoeje2.js\":\"14bb213132ef61f59694d54fc9239e304b2b547fd321695d0dbf099622d9d2b9\",\"assets/index-CWEN0_3t.js\":\"04c8345318559914f7ee6c5a55f85fa74e8869e96bafaa7e60d8c78038c69859\",\"assets/index-DrfhNA8_.css\":\"2a05279a6876bf121c01175a22aee496b2429adc0521a0755d636d146c10bdb3\",\"assets/manage-CcX3nrlg.js\":\"bd11cce50b0d66b6703292175a155105b634fb9760ebf2b49fa3c1f88ffaa2b3\",\"assets/model-BjR3jKsp.css\":\"e7b501306dc22d125bfd1c47dd9ad7e8822c5ccca5776778dd408da0b97061c5\",\"assets/model-Cif-f_GH.js\":\"a6eae789c07db1a1c94fe2ced80423726e6cfb8875bfd6281e9164c2dd176c92\",\"assets/news-DmdqWT7t.js\":\"ae822d745c674d29f1ea92a74d19876ceadf4834770ecc8908de3f8ab88e56eb\",\"assets/parts-BjYuCbll.js\":\"74fd0830a495faad7ceb2b7a19e3bb008b94ba4d4630621a78461f754dfa0ebc\",\"assets/stage-D1mXtv4M.js\":\"58d2fa8e2648727a177b83975fb8773c698577aaf09daaf11dfcb5452f4a21d5\",\"assets/stream-74Es9D9m.js\":\"4dc5782e67ae67d629cf809dc86391fdf89f0f19c730295adad2c396de774bdb\",\"assets/uPlot-CnsZ1jie.css\":\"0fd9465202f6dfceac29e67c17e5ac9fb1b7ba7615c1bb08782391b791d9f1e0\",\"assets/uPlot.esm-BScb58at.js\":\"068506d72590b07d0e53e012ff1541813c52c09bded848b3f97fcd1d4b0fd3b2\",\"favicon.ico\":\"eb66fde2ce87c9f33228184353f8a8c7ff0517cd76eaf9d6a94759bbd7276be9\",\"icon-192.png\":\"df4dde7d57f1963226b36d9501a3b173c02eddc858bef226ae0176dbb4b7ee19\",\"icon-512.png\":\"6e797a05bab65afa3472b6a2bbc42b2f7a33115ab789fa2403c592655657e04d\",\"icon-maskable.png\":\"98caea4e0138a5272161323354bea3585ecac298ff8576823258aeddee01a45f\",\"icon.svg\":\"d12d71c61b9b10bf6b04ba84d91497c272291cd0830c21d5ca98ce2c771fabf2\",\"index.html\":\"a9d9631ab59522a0cb4e84d59ee44685d0231fd592e21a7869867176eb7cbbfd\",\"page.webmanifest\":\"909a00587727949215a61974b50bfb8f15bda9c788e30bb4cdae5af19732dc86\"}");
/** What the page itself names: enough to say that the robot is away. */
const SHELL = JSON.parse("[\"index.html\",\"icon.svg\",\"icon-192.png\",\"page.webmanifest\",\"assets/index-CWEN0_3t.js\",\"assets/access-3cI6PH5L.js\",\"assets/parts-BjYuCbll.js\",\"assets/index-DrfhNA8_.css\"]");
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
