// Keeps the page for a robot that is off or far: the files that it was built with, each checked by its digest, and nothing
// else. What the robot says is never kept. The build fills in the names.
const BUILD = "5b0842a5d3143f64";
/** @type {Record<string, string>} */
const FILES = JSON.parse("{\"assets/Behaviours-ju1TH5lu.css\":\"7df80eb0fe64b2ebddd196abb60e688fe2d0c3fdb01c7e65492934acb953265b\",\"assets/Behaviours-wJTBPjdc.js\":\"0abc84117595bf6e607a5844746503808fde7ce27219bb106918fecdedcb91ae\",\"assets/Below-DFr_a6OG.js\":\"bf2e529eb68fe15dbe7ecef0171d793196b846a62b351b00c335c4bf7d3f3e69\",\"assets/Call-B5myZyvC.css\":\"9bd95ba7d1077c3c66775bc4757281e32365e5b943c7bc7624cd626d4792f397\",\"assets/Call-COul3VIf.js\":\"9b5840e8766da91ac3f123c543627086cff328d8863690d401f81229653d0c4f\",\"assets/Display-S0sxVzzT.js\":\"a0c2563e7ead79a560fcea6276a8d6e23937735269947dd3bda4cc0ba7f89d46\",\"assets/Display-hbDRwTTd.css\":\"c83eeecb550859a06b9cd577a58e8c226d9ef24d37e0f7fb05ec1f901b52e67e\",\"assets/Drive-BIebyx51.js\":\"fbd66beec5a89bc6cb6c2c3679111a9595b75d992d348c0fbb74dae280ef27bf\",\"assets/Drive-DA0oOCw8.css\":\"ca725096dee8c5c674a829996b919b267320060c09db2b5ba6b10b2fc80d0083\",\"assets/Joints-CsAbnF2t.js\":\"4eb1c4096bdf5f6dc290c18bece096cc50bd4ef74215a72fd194ed950e0d938d\",\"assets/Lacking-CacvYTQJ.css\":\"c7c4f4a3d3af03716a518f6da6ec94b34d1ffc67385869d3316d0f32ce4ddef3\",\"assets/Lacking-sGMaceUi.js\":\"e3b5a6c309e113be1395843d32ecdae7a4b27435a1b9a7dd9da315830f04310d\",\"assets/Log-D9Qchsiw.js\":\"fc6802ba881f963e53f0025d7234ffe4e1fb5305190ff5a84f17dd2dd76d874c\",\"assets/Motions-4sPk97he.js\":\"0c076c9e52ca409f369b95bf103a2bd01b1e8a2f401ff908c8dfca9ebcb69f2c\",\"assets/Motions-CaFlTiXz.css\":\"3ae2ef57347e7e60dc54ae7e27f44ce213a22abdda941217da9332eb71385719\",\"assets/System-6GlNAOC3.js\":\"1d89db9cfe3972612fab1e1313a31e9ed5f792497e06c9ef9d01f4680858930c\",\"assets/System-DzGb0BSC.css\":\"24e170c69cd29e16f2088d6e853fad573a6835cf7d5736dadcb7954f3f03fb00\",\"assets/access-BbehHC0K.js\":\"c4d740d57e9a47ed2f1024b3424d98f9acdce670ed6bf207c9b44281922313df\",\"assets/connection-BCqfgZol.js\":\"f586c8575d804c791e5fab9f5208072b92553c65dd1db0fe31c61f214f0c12f2\",\"assets/data-Bx9cKa1I.js\":\"a1fc6382c97056d06d8507ec9ef674ec64eae463d5a2fcc7aa0f57a8295c6596\",\"assets/index-DrfhNA8_.css\":\"2a05279a6876bf121c01175a22aee496b2429adc0521a0755d636d146c10bdb3\",\"assets/index-r0eU82BV.js\":\"e96d55f3dc367f11bb3ddb5ee88580f61544257501d2c0585958ae90ae44b221\",\"assets/manage-BZ_Oh47U.js\":\"ddf6c36aa6b6b37cfc3a0dac88a00f32873b93c92e8da7b21d1b85f8f3e65fe5\",\"assets/model-BjR3jKsp.css\":\"e7b501306dc22d125bfd1c47dd9ad7e8822c5ccca5776778dd408da0b97061c5\",\"assets/model-D-QbKtT-.js\":\"3a48e2582b60e3927782134aee9fe70ac342e7e14e8dcd4984cd86d7461ca6fe\",\"assets/news-DYpiNdac.js\":\"2f2b554586b3f733852e8158cd79da7986f12ec2c480d489fd7c98acc8849a8c\",\"assets/parts-BlR7dvKF.js\":\"388dbcaf55c07cdd864185a2019dd1672eaf1d8eb974c4cdba39ef3777c03bab\",\"assets/stage-BKqNpJ4r.js\":\"ebc458adbda9325c855fec8af4580d4bbbe64cc7ed3890a92f1b157887a1455e\",\"assets/stream-CSBaIV4Z.js\":\"08d8dd16b3d09d13b86b8e96a869b83143df834dc5f91a147cb6a6c7aff5a4ef\",\"assets/uPlot-CnsZ1jie.css\":\"0fd9465202f6dfceac29e67c17e5ac9fb1b7ba7615c1bb08782391b791d9f1e0\",\"assets/uPlot.esm-BScb58at.js\":\"068506d72590b07d0e53e012ff1541813c52c09bded848b3f97fcd1d4b0fd3b2\",\"favicon.ico\":\"eb66fde2ce87c9f33228184353f8a8c7ff0517cd76eaf9d6a94759bbd7276be9\",\"icon-192.png\":\"df4dde7d57f1963226b36d9501a3b173c02eddc858bef226ae0176dbb4b7ee19\",\"icon-512.png\":\"6e797a05bab65afa3472b6a2bbc42b2f7a33115ab789fa2403c592655657e04d\",\"icon-maskable.png\":\"98caea4e0138a5272161323354bea3585ecac298ff8576823258aeddee01a45f\",\"icon.svg\":\"d12d71c61b9b10bf6b04ba84d91497c272291cd0830c21d5ca98ce2c771fabf2\",\"index.html\":\"0a581a0562366a412c7d72993a932802a195f08f2d8ddc4b261ed99f34250e8c\",\"page.webmanifest\":\"909a00587727949215a61974b50bfb8f15bda9c788e30bb4cdae5af19732dc86\"}");
/** What the page itself names: enough to say that the robot is away. */
const SHELL = JSON.parse("[\"index.html\",\"icon.svg\",\"icon-192.png\",\"page.webmanifest\",\"assets/index-r0eU82BV.js\",\"assets/access-BbehHC0K.js\",\"assets/parts-BlR7dvKF.js\",\"assets/index-DrfhNA8_.css\"]");
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
