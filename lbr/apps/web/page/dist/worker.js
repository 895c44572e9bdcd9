// Keeps the page for a robot that is off or far: the files that it was built with, each checked by its digest, and nothing
// else. What the robot says is never kept. The build fills in the names.
const BUILD = "ac9cf230febaff43";
/** @type {Record<string, string>} */
const FILES = JSON.parse("{\"assets/Behaviours-BBPvGF7X.js\":\"6219e28efeda85b21b3ed71f3052bfb59731c2791d3a34999fc213ee83292a3e\",\"assets/Behaviours-ju1TH5lu.css\":\"7df80eb0fe64b2ebddd196abb60e688fe2d0c3fdb01c7e65492934acb953265b\",\"assets/Below-BGBefBh8.js\":\"5af4e40de516c2971e6013ae85d724ec4ee929cc37c4a8ea894cfbde79c065d3\",\"assets/Call-B5myZyvC.css\":\"9bd95ba7d1077c3c66775bc4757281e32365e5b943c7bc7624cd626d4792f397\",\"assets/Call-CIgHy8Br.js\":\"d2a1f161fd46507f7757989444ac4eb7c553c5004a7b0295b9a79efb2f46b2f8\",\"assets/Display-Bv0SJQC6.js\":\"9af0cf90293d15cc9dad34b5cfcf40a2d00998d2add23ebb83288f1391243913\",\"assets/Display-NQ95WRFc.css\":\"7ac5d0b42865202760c3cc3fcdeb9f6aae740f24e27ee4d65c06575e4ae56193\",\"assets/Drive-BXh3BvDb.css\":\"cebbcfa50b8dd0c6a12580c3365a6917902b1b3462e54b1ccc4e554abc36d088\",\"assets/Drive-CDd5kZkS.js\":\"f951408c94b47d1721285d87c987d964238d8dd26d7aa93e3458452b24306423\",\"assets/Joints-BANK2Olc.js\":\"cd92f6102ec2600c5faf36ea6be9088631d4476a8fcacb46c4373d390f7f9b93\",\"assets/Lacking-BexiEtAx.js\":\"ece035efd1021527a1c38f49dd8cd3a44ad3d0730d30896b7b1e40bf07385168\",\"assets/Lacking-CacvYTQJ.css\":\"c7c4f4a3d3af03716a518f6da6ec94b34d1ffc67385869d3316d0f32ce4ddef3\",\"assets/Log-Cw_qYs9t.js\":\"211253cb4e12f89b19b7352db55c38fd4a684d6d79e5ea20c0d02da976209bc9\",\"assets/Motions-CaFlTiXz.css\":\"3ae2ef57347e7e60dc54ae7e27f44ce213a22abdda941217da9332eb71385719\",\"assets/Motions-DX0IBFMl.js\":\"05576c496b7e024ce3b9e5c93994945e65b721b892df8e40cd5e8c4250be5da0\",\"assets/System-CZD1cvWh.js\":\"9c92c3f76febf913668fe9151a2b11ece9fd5b2003ca2b268342c358796e68e4\",\"assets/System-DzGb0BSC.css\":\"24e170c69cd29e16f2088d6e853fad573a6835cf7d5736dadcb7954f3f03fb00\",\"assets/access-DAGGJoxn.js\":\"120b4868746e14a1fdd77366605664ae4f3bcb854430815b36d1e7ed9e8411ff\",\"assets/connection-CJH86UDL.js\":\"0dadeb3e0228dbf00812df8328f0e1a0353636d2cb7cf73d1dfbcaf53f0d182c\",\"assets/data-XKtB-0ej.js\":\"c9b6d7b83a3ffdd3584ff1029b07cc675a7e21c369cdf94be50c553279ba42d2\",\"assets/index-DrfhNA8_.css\":\"2a05279a6876bf121c01175a22aee496b2429adc0521a0755d636d146c10bdb3\",\"assets/index-jrObRY5j.js\":\"9dfd30791a898c903e717d2f9d165c77f7a472f2f7d3f2ba6ae4e4b6c3de9e8c\",\"assets/manage-lUlATWLw.js\":\"a2c0ea785fa7a0704ddd33186fd3900ac239528a8e69255a1b9afd4f741efa68\",\"assets/model-BjR3jKsp.css\":\"e7b501306dc22d125bfd1c47dd9ad7e8822c5ccca5776778dd408da0b97061c5\",\"assets/model-J5DBKfV-.js\":\"7a56d86dc5ed946ca4a136c94951b985a7e064c1693837fbaab70d02a8d2926e\",\"assets/news-BtfRKXNE.js\":\"3e0c97eae744ee545a4d7bb3b5991d0892056fdd0769a6177fa66bdba798207d\",\"assets/stage-Dabt0Hbp.js\":\"110f52ee7c1db1421eaaca6a88fb7be8f0d4610937fd3d5b451f0bda4868dbd8\",\"assets/stream-CBh4S_xS.js\":\"8a86c572f5688e3ebee39e14d4c092a024df5aa6257062d6759b5e5ce20f6a89\",\"assets/uPlot-CnsZ1jie.css\":\"0fd9465202f6dfceac29e67c17e5ac9fb1b7ba7615c1bb08782391b791d9f1e0\",\"assets/uPlot.esm-BScb58at.js\":\"068506d72590b07d0e53e012ff1541813c52c09bded848b3f97fcd1d4b0fd3b2\",\"favicon.ico\":\"eb66fde2ce87c9f33228184353f8a8c7ff0517cd76eaf9d6a94759bbd7276be9\",\"icon-192.png\":\"df4dde7d57f1963226b36d9501a3b173c02eddc858bef226ae0176dbb4b7ee19\",\"icon-512.png\":\"6e797a05bab65afa3472b6a2bbc42b2f7a33115ab789fa2403c592655657e04d\",\"icon-maskable.png\":\"98caea4e0138a5272161323354bea3585ecac298ff8576823258aeddee01a45f\",\"icon.svg\":\"d12d71c61b9b10bf6b04ba84d91497c272291cd0830c21d5ca98ce2c771fabf2\",\"index.html\":\"28b2c3e5e8fd2b57667622d82d936cbe8e77d64c64bd3fbbace01851cd11c84a\",\"page.webmanifest\":\"909a00587727949215a61974b50bfb8f15bda9c788e30bb4cdae5af19732dc86\"}");
/** What the page itself names: enough to say that the robot is away. */
const SHELL = JSON.parse("[\"index.html\",\"icon.svg\",\"icon-192.png\",\"page.webmanifest\",\"assets/index-jrObRY5j.js\",\"assets/access-DAGGJoxn.js\",\"assets/index-DrfhNA8_.css\"]");
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
