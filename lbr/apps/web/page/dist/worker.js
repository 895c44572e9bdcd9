// Keeps the page for a robot that is off or far: the files that it was built with, each checked by its digest, and nothing
// else. What the robot says is never kept. The build fills in the names.
const BUILD = "e0aaf0c54a6f7314";
/** @type {Record<string, string>} */
const FILES = JSON.parse("{\"assets/Behaviours-DGrJ6QOY.js\":\"cffe14470764d99f9c71cf3e70b799d84a0294829a71ce8a6b52ff6e8ba4bc28\",\"assets/Behaviours-ju1TH5lu.css\":\"7df80eb0fe64b2ebddd196abb60e688fe2d0c3fdb01c7e65492934acb953265b\",\"assets/Below-DGDcPQlC.js\":\"37b28b5a05c92ca12b1a05e7c65883d69a364d69d8aba466f25aea7f69f259be\",\"assets/Call-B5myZyvC.css\":\"9bd95ba7d1077c3c66775bc4757281e32365e5b943c7bc7624cd626d4792f397\",\"assets/Call-DrMyI_q0.js\":\"fcb5c590c1247be23a88c8a40fea0694398ac106012cbcb2455696ec13877d27\",\"assets/Display-CvTuhbEt.js\":\"93ad7aeb51b6d85e9eff5c19313a1abf2288d22e0bce06912f595264dacb1200\",\"assets/Display-hbDRwTTd.css\":\"c83eeecb550859a06b9cd577a58e8c226d9ef24d37e0f7fb05ec1f901b52e67e\",\"assets/Drive-DA0oOCw8.css\":\"ca725096dee8c5c674a829996b919b267320060c09db2b5ba6b10b2fc80d0083\",\"assets/Drive-xVSdO2kT.js\":\"9ea96679bb0ea95e8c3c5b80ef4dea5223e5f932971db5eece4c3ee253ed62fe\",\"assets/Joints-By7WXQXJ.js\":\"30e49a413c4704b7a754bbdbf11c3af1183210a2d88ddab220049563a3416a32\",\"assets/Lacking-1gY9IYPE.js\":\"023032431ae2ca7fb0519f7247af6ac6d1b0378d3157dde508da2f0769e590d9\",\"assets/Lacking-CacvYTQJ.css\":\"c7c4f4a3d3af03716a518f6da6ec94b34d1ffc67385869d3316d0f32ce4ddef3\",\"assets/Log-Dc543jVY.js\":\"64d373d7ae8f77ba55e3333c5b4e5fd697bbbc89ef7e29ad0d230b7319a8515a\",\"assets/Motions-CaFlTiXz.css\":\"3ae2ef57347e7e60dc54ae7e27f44ce213a22abdda941217da9332eb71385719\",\"assets/Motions-_MYooRBi.js\":\"3a4896a0902f7fb115b5e259c4fee1ab2eeed3d1f2c1cee25e7038fda3b918d3\",\"assets/System-D1i6_dpm.js\":\"d3cd3bb412f9d0c32a8386b151a28801927e2fdb11275e077eb2d4a4e770d95c\",\"assets/System-DzGb0BSC.css\":\"24e170c69cd29e16f2088d6e853fad573a6835cf7d5736dadcb7954f3f03fb00\",\"assets/access-3cI6PH5L.js\":\"cb8a903691d463f52eac78e36d329ade64aa49dfce63b9c97cb93834388bc2ff\",\"assets/connection-BMeTVRAf.js\":\"430a0cd0a016f95e0773341c8a7c7a1c6104cb06e2a8021d10d05066efe9ab7c\",\"assets/data-CPYCv-DH.js\":\"deb22780ee4502b83ad643c02a2a9494aed9ebc6582a38eb7a0367588c0f300b\",\"assets/index-Cph00IUD.js\":\"f50da33856f1f4fc40a94ec26cf646bb55201c5ee418529b1b60e80ad8056001\",\"assets/index-DrfhNA8_.css\":\"2a05279a6876bf121c01175a22aee496b2429adc0521a0755d636d146c10bdb3\",\"assets/manage-GINRLWce.js\":\"ee5b8a606aec755ffdd014356a0a1ba937eb7bfbf370cc36831b6b53e8bab4a9\",\"assets/model-BjR3jKsp.css\":\"e7b501306dc22d125bfd1c47dd9ad7e8822c5ccca5776778dd408da0b97061c5\",\"assets/model-DzsSEstw.js\":\"120580412708b3a1f50a89f17139219f22137549dbf1395474aba83610dc8d90\",\"assets/news-CBrkGwNV.js\":\"01087ad48fadd36b5cbdacbd5bb5a6aab3784b615c08f199cd4b7df25fb94dee\",\"assets/parts-DkZ_45mG.js\":\"9f182659fb9db37153f2ad2641b699b329c962a8ecf75c6a00078af5e9ed2695\",\"assets/stage-DIoPp6ny.js\":\"31d24432ca6626b5f3a0fd8de4868ece6a345c21b6228fbab6e7b07ca4590da5\",\"assets/stream-BvDmr96U.js\":\"0d00cad6d79b248336b38b7b6333a141f4b88ff1ab34631e9b886a9dbf2c2b26\",\"assets/uPlot-CnsZ1jie.css\":\"0fd9465202f6dfceac29e67c17e5ac9fb1b7ba7615c1bb08782391b791d9f1e0\",\"assets/uPlot.esm-BScb58at.js\":\"068506d72590b07d0e53e012ff1541813c52c09bded848b3f97fcd1d4b0fd3b2\",\"favicon.ico\":\"eb66fde2ce87c9f33228184353f8a8c7ff0517cd76eaf9d6a94759bbd7276be9\",\"icon-192.png\":\"df4dde7d57f1963226b36d9501a3b173c02eddc858bef226ae0176dbb4b7ee19\",\"icon-512.png\":\"6e797a05bab65afa3472b6a2bbc42b2f7a33115ab789fa2403c592655657e04d\",\"icon-maskable.png\":\"98caea4e0138a5272161323354bea3585ecac298ff8576823258aeddee01a45f\",\"icon.svg\":\"d12d71c61b9b10bf6b04ba84d91497c272291cd0830c21d5ca98ce2c771fabf2\",\"index.html\":\"c0d37f773291f2adf9dc187bc58f42d4b102f4e55e1f23635bf21a27536f0a79\",\"page.webmanifest\":\"909a00587727949215a61974b50bfb8f15bda9c788e30bb4cdae5af19732dc86\"}");
/** What the page itself names: enough to say that the robot is away. */
const SHELL = JSON.parse("[\"index.html\",\"icon.svg\",\"icon-192.png\",\"page.webmanifest\",\"assets/index-Cph00IUD.js\",\"assets/access-3cI6PH5L.js\",\"assets/parts-DkZ_45mG.js\",\"assets/index-DrfhNA8_.css\"]");
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
