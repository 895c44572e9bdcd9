// Keeps the page for a robot that is off or far: the files that it was built with, each checked by its digest, and nothing
// else. What the robot says is never kept. The build fills in the names.
const BUILD = "43652971319da2a5";
/** @type {Record<string, string>} */
const FILES = JSON.parse("{\"assets/Behaviours-CheEvxdd.js\":\"461965718af965c73a5d4674d4be76fbec94112bdcc36f9758026236963c0ca9\",\"assets/Behaviours-ju1TH5lu.css\":\"7df80eb0fe64b2ebddd196abb60e688fe2d0c3fdb01c7e65492934acb953265b\",\"assets/Below-CfYkVVSI.js\":\"5ca5a641262b8fc4565463567bf70d8f2979de175fe8317a0e176bdf7fc8b667\",\"assets/Call-B5myZyvC.css\":\"9bd95ba7d1077c3c66775bc4757281e32365e5b943c7bc7624cd626d4792f397\",\"assets/Call-BDEAEaYe.js\":\"f645477b8bedbf49892d6eb3d6f5926da99718f043d0219ee276276e7d85b3dd\",\"assets/Display-BeLH-9zP.js\":\"2c000e11bf35260fed915957042e955e5310c6b46c08d66f60c808f20badded6\",\"assets/Display-NQ95WRFc.css\":\"7ac5d0b42865202760c3cc3fcdeb9f6aae740f24e27ee4d65c06575e4ae56193\",\"assets/Drive-3B4RxMj9.js\":\"e4e5f026eeb0b28fc418c791e9aa8a004ad50227751a2369764c4d9961d1d27c\",\"assets/Drive-DA0oOCw8.css\":\"ca725096dee8c5c674a829996b919b267320060c09db2b5ba6b10b2fc80d0083\",\"assets/Joints-91PtRXky.js\":\"3305d021ca77a4d94d2636147540d37fa2a2892099e96fa6ff672fe4ca33b94c\",\"assets/Lacking-CacvYTQJ.css\":\"c7c4f4a3d3af03716a518f6da6ec94b34d1ffc67385869d3316d0f32ce4ddef3\",\"assets/Lacking-DSxd6YTd.js\":\"e5554321854bdef2394d5475c8a74ca0fdd5ff75a3d191e6f24886a148308d43\",\"assets/Log-DABn5suR.js\":\"f8c4360fb1890b960fbe30b6e1358d25b34b8576325c856404db88c68a78eb1c\",\"assets/Motions-CaFlTiXz.css\":\"3ae2ef57347e7e60dc54ae7e27f44ce213a22abdda941217da9332eb71385719\",\"assets/Motions-D1dYxi1K.js\":\"9597ecc31a8ae293759c36c67bbc9f73c7835e40c9f5d7eece47d4f324d34f0e\",\"assets/System-CkaAO5s1.js\":\"1de47ac4c5574be4c7c9cfb8a091a190eaccdff5b1a03c9700f5d394939c661c\",\"assets/System-DzGb0BSC.css\":\"24e170c69cd29e16f2088d6e853fad573a6835cf7d5736dadcb7954f3f03fb00\",\"assets/access-BmOYO4wi.js\":\"71fbc49e11aae2ee5e6fe18ab6944691ebbe31a27125910f97e14f10f84c2342\",\"assets/connection-CHiUa6dp.js\":\"fac976977bee728435ab3e965a337d256b6032de0ec09e6c364dbf1f82fbf23a\",\"assets/data-BmPrnZL5.js\":\"61500e98ca73cbab43b528be8903cd9c3af3d488fd04de7d8dae38db0782f136\",\"assets/index-DM2aOEU6.js\":\"1a2fbd6af10d3994bd499336282131ce07eebe13760fe22114388a2b989b8781\",\"assets/index-DrfhNA8_.css\":\"2a05279a6876bf121c01175a22aee496b2429adc0521a0755d636d146c10bdb3\",\"assets/manage-BRnoL4w5.js\":\"f76d27307404a48d425b59d1da3b60d1cc4a20a09525dab14e7e007860b16622\",\"assets/model-BjR3jKsp.css\":\"e7b501306dc22d125bfd1c47dd9ad7e8822c5ccca5776778dd408da0b97061c5\",\"assets/model-DTdX0_05.js\":\"ad308b2fc6186cc2d062f729959221b4e134b0a6364346cb7a7ca8b9a747dff7\",\"assets/news-BKnJHDtr.js\":\"505f36012b48dfac2c61039fd7c60cf561dcf035bb1946cd4a964c48aa450242\",\"assets/stage-BgevgF01.js\":\"6eba2811ffe7e8c2fe32cc6e1766eeda3a282c2b4639b03dfda3c1229c00d8df\",\"assets/stream-BNi0nx09.js\":\"a0d98a540acb22c8561c2adc27d74b9f978f6ede0588b007c05b5192e5b7a2f7\",\"assets/uPlot-CnsZ1jie.css\":\"0fd9465202f6dfceac29e67c17e5ac9fb1b7ba7615c1bb08782391b791d9f1e0\",\"assets/uPlot.esm-BScb58at.js\":\"068506d72590b07d0e53e012ff1541813c52c09bded848b3f97fcd1d4b0fd3b2\",\"favicon.ico\":\"eb66fde2ce87c9f33228184353f8a8c7ff0517cd76eaf9d6a94759bbd7276be9\",\"icon-192.png\":\"df4dde7d57f1963226b36d9501a3b173c02eddc858bef226ae0176dbb4b7ee19\",\"icon-512.png\":\"6e797a05bab65afa3472b6a2bbc42b2f7a33115ab789fa2403c592655657e04d\",\"icon-maskable.png\":\"98caea4e0138a5272161323354bea3585ecac298ff8576823258aeddee01a45f\",\"icon.svg\":\"d12d71c61b9b10bf6b04ba84d91497c272291cd0830c21d5ca98ce2c771fabf2\",\"index.html\":\"9c656f0f45ae2319d20d1c1df43ca3a0f5a401fc6c24463c42cfcd5a23e9c20b\",\"page.webmanifest\":\"909a00587727949215a61974b50bfb8f15bda9c788e30bb4cdae5af19732dc86\"}");
/** What the page itself names: enough to say that the robot is away. */
const SHELL = JSON.parse("[\"index.html\",\"icon.svg\",\"icon-192.png\",\"page.webmanifest\",\"assets/index-DM2aOEU6.js\",\"assets/access-BmOYO4wi.js\",\"assets/index-DrfhNA8_.css\"]");
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
