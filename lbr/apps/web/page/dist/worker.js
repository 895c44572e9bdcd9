// Keeps the page for a robot that is off or far: the files that it was built with, each checked by its digest, and nothing
// else. What the robot says is never kept. The build fills in the names.
const BUILD = "cd34576e59e8c563";
/** @type {Record<string, string>} */
const FILES = JSON.parse("{\"assets/Behaviours-CFbFg9zl.js\":\"23a330d1384082946508bc552bb94cb19a861e12840ba78fc37808d1926cabf0\",\"assets/Behaviours-CW6UGM9H.css\":\"f8ec05f55e6ffeb2c0ecf622c8f86b9bcd1e9fc4197c1fb4ed8135c322d9d1a4\",\"assets/Below-CAmBj4Y3.js\":\"98e479ea028a03276e3e9215e69eba21f70b89d92be81d8d1c7f2a95226662a1\",\"assets/Call-BH-FlvRt.css\":\"72c27a044611bd5e73568c62521730576fefce8c2a7bc35fb38ab268f89da215\",\"assets/Call-CQnnbYCN.js\":\"df89d655abaca189e694d8e13f1f38211e5f4789160863c985154d70a70def17\",\"assets/Display-hbDRwTTd.css\":\"c83eeecb550859a06b9cd577a58e8c226d9ef24d37e0f7fb05ec1f901b52e67e\",\"assets/Display-zFoUyvCI.js\":\"1e94087c049ad5f82a695bdca572051cc54b226399d23490b6573e850bfc0848\",\"assets/Drive-CguKo-Or.css\":\"502d412c4055f2c0f7d9d3a0c36f04fb07c4402f07fc5410662c1d7eb0c43be9\",\"assets/Drive-NBfoaXZS.js\":\"5903eee455c1cd4759d3239574b013aebe6202e92e298e43f6a29c1f4add5467\",\"assets/Joints-oP6E551Z.js\":\"5fba775eef8970c3fc7878d20792c92ae66f829e07ab555a3969ea5d765b41de\",\"assets/Lacking-CacvYTQJ.css\":\"c7c4f4a3d3af03716a518f6da6ec94b34d1ffc67385869d3316d0f32ce4ddef3\",\"assets/Lacking-DAlhAKtE.js\":\"a0fc007418923b83c99f194f2e19d9e498637c9b9152d4cd1953dfccd49a17ad\",\"assets/Log-CmRvT118.js\":\"3457da3dffb77b0f31bdc5da8aab8d5c015cb682fbe0889e451306bfbed9e238\",\"assets/Motions-DhF4kr9k.js\":\"4574118e5d530ab3bc6de8cdfdea36bcfd34b276427ea2c0102afc7f02d8feec\",\"assets/Motions-_yckXxin.css\":\"2433d9b632a30f7a464cc23593c6e0c8506e1ef700457cbf68b5345c87be19b0\",\"assets/System-BeBMxsaO.js\":\"c6313c05f9c5de4033700f037f09167c065766115151cd776b6378caa4b0f894\",\"assets/System-CAGU8Dof.css\":\"ae933e9c36299104bd16c32c77243303a9aac415f91195177bf4a3e59a11cf9e\",\"assets/access-BFjq4TgM.js\":\"2a6baf419783455d3d827125d039df70d6d2e9ed3be6799f5e8fae08afa49ba8\",\"assets/connection-DXk-nleZ.js\":\"dc99ef35e3caafe880644972990a0948444dd1854c1192fc72cfa50c573dde06\",\"assets/index-BNq47LIe.css\":\"abebc68eb2b3607f184da8250630305b9abf452212c4c7f3b5027f4986a6115d\",\"assets/index-DZx2PTSt.js\":\"6dfb9bec0abb036cb53fb589950421226bf5f734c6e797c34db041726ee16a49\",\"assets/manage-CLhQIGe2.js\":\"b3cc3efcd883f8702f12cad12fbe299228a9325aa58ae629261571645532fd03\",\"assets/model-BcREX_c-.js\":\"574541b040b5719dd4ac13bd18198d083d8bb14836510364148b2f95cd102e43\",\"assets/model-BhDZKaW7.css\":\"6c5740c3b5ac779d9bac281576b4fbb48c5da54a165bce2a4712f8052b110d74\",\"assets/news-BfXBvduD.js\":\"e12e139ae19e99a55f4532a7aa213790f9e5cbd0d543f68059a73b0e951eb8ac\",\"assets/parts-B_QQRBiZ.js\":\"dec1851fec99aaa66ad5867ea2e042fe63cd3b8a4ac0a656421956b0520a265a\",\"assets/saving-DbPjuOQb.js\":\"94d1a2e76767f7fdfe2e444b94c2326a340904bc4ede0b5445dbbf7236821d66\",\"assets/stage-CkiixefV.js\":\"1f4c6b0abf7a739fdd8851002a0e3b5b77d1a53973f8b12094c645c20c42988b\",\"assets/stream-BhpPt-xi.js\":\"351cda71433d0b810520062ec435b6482de1d9ec825785afbeef63a9965b408f\",\"assets/uPlot-CnsZ1jie.css\":\"0fd9465202f6dfceac29e67c17e5ac9fb1b7ba7615c1bb08782391b791d9f1e0\",\"assets/uPlot.esm-BScb58at.js\":\"068506d72590b07d0e53e012ff1541813c52c09bded848b3f97fcd1d4b0fd3b2\",\"favicon.ico\":\"eb66fde2ce87c9f33228184353f8a8c7ff0517cd76eaf9d6a94759bbd7276be9\",\"icon-192.png\":\"df4dde7d57f1963226b36d9501a3b173c02eddc858bef226ae0176dbb4b7ee19\",\"icon-512.png\":\"6e797a05bab65afa3472b6a2bbc42b2f7a33115ab789fa2403c592655657e04d\",\"icon-maskable.png\":\"98caea4e0138a5272161323354bea3585ecac298ff8576823258aeddee01a45f\",\"icon.svg\":\"d12d71c61b9b10bf6b04ba84d91497c272291cd0830c21d5ca98ce2c771fabf2\",\"index.html\":\"0074c876493193ba04a3e6db8252289ba6584b946cb3502cedc691761763039b\",\"page.webmanifest\":\"909a00587727949215a61974b50bfb8f15bda9c788e30bb4cdae5af19732dc86\"}");
/** What the page itself names: enough to say that the robot is away. */
const SHELL = JSON.parse("[\"index.html\",\"icon.svg\",\"icon-192.png\",\"page.webmanifest\",\"assets/index-DZx2PTSt.js\",\"assets/access-BFjq4TgM.js\",\"assets/parts-B_QQRBiZ.js\",\"assets/index-BNq47LIe.css\"]");
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
