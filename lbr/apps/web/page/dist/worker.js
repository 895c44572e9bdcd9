// Keeps the page for a robot that is off or far: the files that it was built with, each checked by its digest, and nothing
// else. What the robot says is never kept. The build fills in the names.
const BUILD = "d598a19d11189f33";
/** @type {Record<string, string>} */
const FILES = JSON.parse("{\"assets/Behaviours-hYlFHpJV.js\":\"3fcb484a07533098d606b60076e70913e77cd22c28510859cbfcb6d8663ee4ee\",\"assets/Behaviours-ju1TH5lu.css\":\"7df80eb0fe64b2ebddd196abb60e688fe2d0c3fdb01c7e65492934acb953265b\",\"assets/Below-BaisLtEE.js\":\"f15d6336758f34a60b9847b2a2ee239f3012ac385958bb39a536f33e06c4bc88\",\"assets/Call-B5myZyvC.css\":\"9bd95ba7d1077c3c66775bc4757281e32365e5b943c7bc7624cd626d4792f397\",\"assets/Call-CepmCGKW.js\":\"5f5743f8f709aa93c41a750e5da66be38eb878db986cd0b80d8086b48bcde4f1\",\"assets/Display-D6_1r9L6.js\":\"402b2002963f669c121987707c1c5b91470aedf3b5431b115845de218af9d106\",\"assets/Display-NQ95WRFc.css\":\"7ac5d0b42865202760c3cc3fcdeb9f6aae740f24e27ee4d65c06575e4ae56193\",\"assets/Drive-BXh3BvDb.css\":\"cebbcfa50b8dd0c6a12580c3365a6917902b1b3462e54b1ccc4e554abc36d088\",\"assets/Drive-dCcxe8C7.js\":\"bdbaee1d41266d1d9c28826cd78193e3c9755dc5738c98d8285f16236c13a02e\",\"assets/Joints-wnfmdAGx.js\":\"039ae39c024b33a462a3afd3e142c610900eea04afbfffaa31a54b05a255cda3\",\"assets/Lacking-CNCQ8yBT.js\":\"8bd6703800c9bd692870b05b8b3d2ecb57b3c7c5e43299c9fccf054014360562\",\"assets/Lacking-CacvYTQJ.css\":\"c7c4f4a3d3af03716a518f6da6ec94b34d1ffc67385869d3316d0f32ce4ddef3\",\"assets/Log-C7nDVw4_.js\":\"60dc31ea3286c7fddc76de7fbe14345560532f9e685f21ceef29232204bc6dd4\",\"assets/Motions-CaFlTiXz.css\":\"3ae2ef57347e7e60dc54ae7e27f44ce213a22abdda941217da9332eb71385719\",\"assets/Motions-YHpJahkV.js\":\"56189f9163b15376e28d89e03dc3eeea2775ec133e92821a2d090103d72f42ed\",\"assets/System-D6W_oQ6T.js\":\"840b54056f2b5bf7dcf3431fed8399b56bca2f7ad32766b9bc77d54754af1aa4\",\"assets/System-DzGb0BSC.css\":\"24e170c69cd29e16f2088d6e853fad573a6835cf7d5736dadcb7954f3f03fb00\",\"assets/access-DAGGJoxn.js\":\"120b4868746e14a1fdd77366605664ae4f3bcb854430815b36d1e7ed9e8411ff\",\"assets/connection-CJH86UDL.js\":\"0dadeb3e0228dbf00812df8328f0e1a0353636d2cb7cf73d1dfbcaf53f0d182c\",\"assets/data-Bc_yYoqg.js\":\"24b9d18bd07e31a7e3a9dbf8e129731a3a3397c11eae7ff90420fffa853dee62\",\"assets/index-B2ikFJlL.js\":\"998c2739e93ae4fd06216f42dc5346a90f3a186ea7bdf8bf4d2a295ffaa963db\",\"assets/index-DrfhNA8_.css\":\"2a05279a6876bf121c01175a22aee496b2429adc0521a0755d636d146c10bdb3\",\"assets/manage-BJDEdZSb.js\":\"0948f50b04c46fe0c52465dd7a97062523d42cd114ca16b1dc6d2d2245ba10e4\",\"assets/model-BjR3jKsp.css\":\"e7b501306dc22d125bfd1c47dd9ad7e8822c5ccca5776778dd408da0b97061c5\",\"assets/model-FSfVnbs2.js\":\"0187c47882d54d0e4bd07b23bab77b212633d856d833350b3083c8a1040ee2bc\",\"assets/news-DTd9M3eq.js\":\"a91a4ddf507b5f66040aaa24e4ba7c6b93b7177c5099430c313bd1717db33bd7\",\"assets/stage-I7IufjXq.js\":\"f44a43a048545a3fc18793499ada000309361c42144bec96f2fa89427dbce198\",\"assets/stream-DLI_pyd2.js\":\"92681ad227dbd592131d4dc17620e1130fd1b0efd055b4c35202c8b5df0a6ca1\",\"assets/uPlot-CnsZ1jie.css\":\"0fd9465202f6dfceac29e67c17e5ac9fb1b7ba7615c1bb08782391b791d9f1e0\",\"assets/uPlot.esm-BScb58at.js\":\"068506d72590b07d0e53e012ff1541813c52c09bded848b3f97fcd1d4b0fd3b2\",\"favicon.ico\":\"eb66fde2ce87c9f33228184353f8a8c7ff0517cd76eaf9d6a94759bbd7276be9\",\"icon-192.png\":\"df4dde7d57f1963226b36d9501a3b173c02eddc858bef226ae0176dbb4b7ee19\",\"icon-512.png\":\"6e797a05bab65afa3472b6a2bbc42b2f7a33115ab789fa2403c592655657e04d\",\"icon-maskable.png\":\"98caea4e0138a5272161323354bea3585ecac298ff8576823258aeddee01a45f\",\"icon.svg\":\"d12d71c61b9b10bf6b04ba84d91497c272291cd0830c21d5ca98ce2c771fabf2\",\"index.html\":\"679f039b8b1ff3677dead2c8f1693d9dbb907b626e1f5d81ef26b2b2d811e083\",\"page.webmanifest\":\"909a00587727949215a61974b50bfb8f15bda9c788e30bb4cdae5af19732dc86\"}");
/** What the page itself names: enough to say that the robot is away. */
const SHELL = JSON.parse("[\"index.html\",\"icon.svg\",\"icon-192.png\",\"page.webmanifest\",\"assets/index-B2ikFJlL.js\",\"assets/access-DAGGJoxn.js\",\"assets/index-DrfhNA8_.css\"]");
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
