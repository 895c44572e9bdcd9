// Keeps the page for a robot that is off or far: the files that it was built with, each checked by its digest, and nothing
// else. What the robot says is never kept. The build fills in the names.
const BUILD = "726725394b41cead";
/** @type {Record<string, string>} */
const FILES = JSON.parse("{\"assets/Behaviours-D6E_dp5M.js\":\"480b62db58093113f69efcf1e33b6b198b060ff7cd43ff56fc0e866b44adc6e1\",\"assets/Behaviours-ju1TH5lu.css\":\"7df80eb0fe64b2ebddd196abb60e688fe2d0c3fdb01c7e65492934acb953265b\",\"assets/Below-CnnL6YB9.js\":\"ea11f0269ca08b2b6cde8cdbecd558ab8149c3b059cdafbcd817b1a26d2b3c8e\",\"assets/Call-B5myZyvC.css\":\"9bd95ba7d1077c3c66775bc4757281e32365e5b943c7bc7624cd626d4792f397\",\"assets/Call-HqRt2PBm.js\":\"06123418df1bea4f8ee4f91004ced74ecbcef8a234d01b3ed71b1138c382deb5\",\"assets/Display-Cu-a2K1Z.js\":\"f9fc280b38d86bbc71717ef9b616174d89bce582593369c982cc85a6868b7fe6\",\"assets/Display-NQ95WRFc.css\":\"7ac5d0b42865202760c3cc3fcdeb9f6aae740f24e27ee4d65c06575e4ae56193\",\"assets/Drive-DA0oOCw8.css\":\"ca725096dee8c5c674a829996b919b267320060c09db2b5ba6b10b2fc80d0083\",\"assets/Drive-D_yDHlmR.js\":\"f730f90b173921a357367018ccb3ca8e415f14b2bab4e5662ddb33fa132d25f9\",\"assets/Joints-PsQEybgl.js\":\"3aa5b65031e5b14f4cfa085bd3437a98f8b406e74f8a615b1132ccbdb356493a\",\"assets/Lacking-BTXcp5hT.js\":\"59a9e52eecf0c7e8522a9e93e73fbb42e1d9afaf2d3d8cf7a6ba150ad0618676\",\"assets/Lacking-CacvYTQJ.css\":\"c7c4f4a3d3af03716a518f6da6ec94b34d1ffc67385869d3316d0f32ce4ddef3\",\"assets/Log-CqOPsW0W.js\":\"a13e2df5b0f381b0d2a8118e2fa3460681707fe9e78f15eb28a1822bed3ae26f\",\"assets/Motions-CaFlTiXz.css\":\"3ae2ef57347e7e60dc54ae7e27f44ce213a22abdda941217da9332eb71385719\",\"assets/Motions-DQopkVeD.js\":\"b1231c61aba5ccb0c43a7af5b7e0ed1bf601aad6d2d4e2c8fc4292ffa62d2c94\",\"assets/System-BuGvslOq.js\":\"f92605195b71348769f3b2557c12a0e550ea0db9c46ea0b0343f8f1f44b72ba7\",\"assets/System-DzGb0BSC.css\":\"24e170c69cd29e16f2088d6e853fad573a6835cf7d5736dadcb7954f3f03fb00\",\"assets/access-Bo-Vzv95.js\":\"93cad159bb2a564f41a5a5c4b1689cd0717639d4b3800ef503b3fffbb2ddd6dc\",\"assets/connection-Dvo7fElK.js\":\"f6aa47b649d7d280c6ab14159e23a5defce7b27b39081131edecf409c8bdaf44\",\"assets/data-c4WjfxzF.js\":\"0f674d243f7f15bac898a9cc70ec71f1928c1c7a0b601b1fa680f01632381b85\",\"assets/index-DrfhNA8_.css\":\"2a05279a6876bf121c01175a22aee496b2429adc0521a0755d636d146c10bdb3\",\"assets/index-ofNvJk-R.js\":\"b362720048d75e235ae1531e5f38ec98fddd43c5d61fe600d4b4d8aa0b706b38\",\"assets/manage-CkvWipu8.js\":\"afaeee60d3b94caec4df8de8feeb9c21701bde028e3628d2f409d46116ce3424\",\"assets/model-BjR3jKsp.css\":\"e7b501306dc22d125bfd1c47dd9ad7e8822c5ccca5776778dd408da0b97061c5\",\"assets/model-DIbwqHVq.js\":\"f5785b5469875b0465a077135a00b9fef445b7de18b1274088bbc36cb1dff2f6\",\"assets/news-DE_L8BI_.js\":\"e983dda6575a33561243ee921e19fc053ed749703301c3df7b20488d5b2a3f28\",\"assets/stage-97ZXpb9D.js\":\"54386bdb22d1376367233e533da805f8e9e23051154b58c533282e50c2b6875e\",\"assets/stream-BEoD_uSE.js\":\"1f6dc01d0f15732d2e0c025b3be2f29ec6cbb9b25956ffe9a07ec7cc7bd8e360\",\"assets/uPlot-CnsZ1jie.css\":\"0fd9465202f6dfceac29e67c17e5ac9fb1b7ba7615c1bb08782391b791d9f1e0\",\"assets/uPlot.esm-BScb58at.js\":\"068506d72590b07d0e53e012ff1541813c52c09bded848b3f97fcd1d4b0fd3b2\",\"favicon.ico\":\"eb66fde2ce87c9f33228184353f8a8c7ff0517cd76eaf9d6a94759bbd7276be9\",\"icon-192.png\":\"df4dde7d57f1963226b36d9501a3b173c02eddc858bef226ae0176dbb4b7ee19\",\"icon-512.png\":\"6e797a05bab65afa3472b6a2bbc42b2f7a33115ab789fa2403c592655657e04d\",\"icon-maskable.png\":\"98caea4e0138a5272161323354bea3585ecac298ff8576823258aeddee01a45f\",\"icon.svg\":\"d12d71c61b9b10bf6b04ba84d91497c272291cd0830c21d5ca98ce2c771fabf2\",\"index.html\":\"edd53b4cc69169732dacbfa26db386660f2630157c02e1352e7869cdb379fc30\",\"page.webmanifest\":\"909a00587727949215a61974b50bfb8f15bda9c788e30bb4cdae5af19732dc86\"}");
/** What the page itself names: enough to say that the robot is away. */
const SHELL = JSON.parse("[\"index.html\",\"icon.svg\",\"icon-192.png\",\"page.webmanifest\",\"assets/index-ofNvJk-R.js\",\"assets/access-Bo-Vzv95.js\",\"assets/index-DrfhNA8_.css\"]");
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
