// Keeps the page for a robot that is off or far: the files that it was built with, each checked by its digest, and nothing
// else. What the robot says is never kept. The build fills in the names.
const BUILD = "7f754399fdc768ce";
/** @type {Record<string, string>} */
const FILES = JSON.parse("{\"assets/Behaviours-DQCHdhDX.js\":\"739688d04832924d3a3260877f96454ddd195173d19d3977be9fe2c692ecaf1f\",\"assets/Behaviours-ju1TH5lu.css\":\"7df80eb0fe64b2ebddd196abb60e688fe2d0c3fdb01c7e65492934acb953265b\",\"assets/Below-Nwz7lJbR.js\":\"e97af6515d9cb17078c4c1056b64bbaefa4affbd328feed3ebf2a74e0a29895e\",\"assets/Call-B5myZyvC.css\":\"9bd95ba7d1077c3c66775bc4757281e32365e5b943c7bc7624cd626d4792f397\",\"assets/Call-CT13pVIM.js\":\"31bf931ce24ee5c5b5c87c701f2845e18cd752e31bdaff7092c0a51dcaa73d59\",\"assets/Display-Dp9nqNSz.js\":\"1e9708d9d5103b776c40dfb0ca4d64271078c9ea3780c1ee415aad55788fcf33\",\"assets/Display-hbDRwTTd.css\":\"c83eeecb550859a06b9cd577a58e8c226d9ef24d37e0f7fb05ec1f901b52e67e\",\"assets/Drive-DA0oOCw8.css\":\"ca725096dee8c5c674a829996b919b267320060c09db2b5ba6b10b2fc80d0083\",\"assets/Drive-DsmKB-Br.js\":\"27c371ee21de666e1d1391e3c81503d6d85109aee4737b9b1ae1ce9e4fd7fd85\",\"assets/Joints-lNHjK39a.js\":\"2879618164d0f9a4c8734d20243fa127d7cc511e3d14501a6bec2b930527f50f\",\"assets/Lacking-BEWrxuGN.js\":\"030d048d856895787d01fbef2056b5e975f6ca0db488d1681ab97237f467246b\",\"assets/Lacking-CacvYTQJ.css\":\"c7c4f4a3d3af03716a518f6da6ec94b34d1ffc67385869d3316d0f32ce4ddef3\",\"assets/Log-B74E0uLk.js\":\"9a3ff81e2db8be2dee550ed2179036537483aaec75666fdaefe6f427bb858ae6\",\"assets/Motions-CaFlTiXz.css\":\"3ae2ef57347e7e60dc54ae7e27f44ce213a22abdda941217da9332eb71385719\",\"assets/Motions-DrDke1h2.js\":\"b20eaa1529772d33e070b308a5429af2cfa164007e97a20c23f3876f30500629\",\"assets/System-DzGb0BSC.css\":\"24e170c69cd29e16f2088d6e853fad573a6835cf7d5736dadcb7954f3f03fb00\",\"assets/System-VuFzAZO5.js\":\"3293b07c6f9c4bdd9ed022e4097b709dc95e82553bd85ad0c51a2ff4d9f7cd3d\",\"assets/access-B0rs1E-b.js\":\"779d18a0e39d3430f85911164c6a1100ad1e01cae2a11cb6fb6558ad954e8d72\",\"assets/connection-BIJEwFev.js\":\"6add713d17ad251ed47024aa72f1c14fa35b94034819f5cabdf8352fb105d839\",\"assets/data-0WjOemK3.js\":\"546eb583a17f09193ed01b5d8b693b547fada7d82663e19ce48a20ed19d8f50f\",\"assets/index-DLsgKrKy.js\":\"15bf25cb1b0b8f0322c67b27407f83406b932cd4451c016a3d18090288e98a70\",\"assets/index-DrfhNA8_.css\":\"2a05279a6876bf121c01175a22aee496b2429adc0521a0755d636d146c10bdb3\",\"assets/manage-BYCn3BjS.js\":\"52ac83461dc96956600d5da963a29f11ba2f1347de29bf362ff7c2228b15c8a8\",\"assets/model-BjR3jKsp.css\":\"e7b501306dc22d125bfd1c47dd9ad7e8822c5ccca5776778dd408da0b97061c5\",\"assets/model-iznEGqFw.js\":\"4a797d5a397060eb9dc7b679f806e623e74dcb334a2e64003b0b0a74c6746aec\",\"assets/news-BLntLdXt.js\":\"53ef9e12c465eedc6662877ec934537ffa7366512fb187c117fe00b136cbcb79\",\"assets/stage-BOR0LlI2.js\":\"8979f6b48606f5c1201fac73465e87c78715b91175c3573f25043090390ffc62\",\"assets/stream-CiJgrXrn.js\":\"d0b4502a0499f02158ecf3275d81b39435154585b968ee54d0c31567dd09bd2c\",\"assets/uPlot-CnsZ1jie.css\":\"0fd9465202f6dfceac29e67c17e5ac9fb1b7ba7615c1bb08782391b791d9f1e0\",\"assets/uPlot.esm-BScb58at.js\":\"068506d72590b07d0e53e012ff1541813c52c09bded848b3f97fcd1d4b0fd3b2\",\"favicon.ico\":\"eb66fde2ce87c9f33228184353f8a8c7ff0517cd76eaf9d6a94759bbd7276be9\",\"icon-192.png\":\"df4dde7d57f1963226b36d9501a3b173c02eddc858bef226ae0176dbb4b7ee19\",\"icon-512.png\":\"6e797a05bab65afa3472b6a2bbc42b2f7a33115ab789fa2403c592655657e04d\",\"icon-maskable.png\":\"98caea4e0138a5272161323354bea3585ecac298ff8576823258aeddee01a45f\",\"icon.svg\":\"d12d71c61b9b10bf6b04ba84d91497c272291cd0830c21d5ca98ce2c771fabf2\",\"index.html\":\"a12b809d623fd28aadd18fc0b0bba663d9b939e21cb8c50a1602a029f7ba72c0\",\"page.webmanifest\":\"909a00587727949215a61974b50bfb8f15bda9c788e30bb4cdae5af19732dc86\"}");
/** What the page itself names: enough to say that the robot is away. */
const SHELL = JSON.parse("[\"index.html\",\"icon.svg\",\"icon-192.png\",\"page.webmanifest\",\"assets/index-DLsgKrKy.js\",\"assets/access-B0rs1E-b.js\",\"assets/index-DrfhNA8_.css\"]");
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
