// Keeps the page for a robot that is off or far: the files that it was built with, each checked by its digest, and nothing
// else. What the robot says is never kept. The build fills in the names.
const BUILD = "2dbc030e5f0ba93a";
/** @type {Record<string, string>} */
const FILES = JSON.parse("{\"assets/Behaviours-CP8xCyEa.js\":\"0e6fcf861de0bdf8e99843f8c98478428aa11aa769e8fa90e1c135975e4b5357\",\"assets/Behaviours-CW6UGM9H.css\":\"f8ec05f55e6ffeb2c0ecf622c8f86b9bcd1e9fc4197c1fb4ed8135c322d9d1a4\",\"assets/Below-Bgd79msA.js\":\"abc58d5e5a93531809123098392b1f59e449863f5a80a53471499cbf16f86790\",\"assets/Call-4AmQ-Xyz.js\":\"3a22396b026d4d28516cb45ed279dc69f0a92a73b6d6e9e305c9d79ce38df52e\",\"assets/Call-BH-FlvRt.css\":\"72c27a044611bd5e73568c62521730576fefce8c2a7bc35fb38ab268f89da215\",\"assets/Display-hbDRwTTd.css\":\"c83eeecb550859a06b9cd577a58e8c226d9ef24d37e0f7fb05ec1f901b52e67e\",\"assets/Display-lMWcgEoM.js\":\"5394bdfe76a767babd718ad507dff6aeb48d3882b32d6302d26f2e721f2baed5\",\"assets/Drive-CR6ABvP3.js\":\"cb0f7d995ad77eeb5adefe7580b9df9c456807665685f7f8e1b69dfcef2bec54\",\"assets/Drive-CguKo-Or.css\":\"502d412c4055f2c0f7d9d3a0c36f04fb07c4402f07fc5410662c1d7eb0c43be9\",\"assets/Joints-D5LQF9I3.js\":\"aab7bcff9dd2fac043b5bde98406780019bbffaf3beb77b19a24facfc17c45d9\",\"assets/Lacking-CacvYTQJ.css\":\"c7c4f4a3d3af03716a518f6da6ec94b34d1ffc67385869d3316d0f32ce4ddef3\",\"assets/Lacking-D1cqXkVF.js\":\"a60daf52a43ecee2ffe1aab8e34b7f267060a50903f242ad9e3b8b4a05449bd0\",\"assets/Log-CFWAjaC0.js\":\"e5fa06c5dd1a0b99e9ab97186797a8ee62207df8e8cc7f18e462607b10aeb0cb\",\"assets/Motions-BvJZpnow.js\":\"b52c40aafd0b2f8a01a1107115f07a79e18e6db979adb5796f6737d9f6859bf1\",\"assets/Motions-CJQoRpbq.css\":\"da3e78579f8d170defd81f9b2104226e0f00b6d94db24d4203e26b51d8c102ac\",\"assets/System-6enrdjHs.js\":\"cac1c41f5f5abb4048103eaf33b3eb6fa5d44def24c3c5f5c931fb7a4d254765\",\"assets/System-CAGU8Dof.css\":\"ae933e9c36299104bd16c32c77243303a9aac415f91195177bf4a3e59a11cf9e\",\"assets/access-B0lmsRTm.js\":\"ddc8b6dfb0151e2a408f557693a4232806d7c0d20a081131a522e9a12418db74\",\"assets/connection-C83dZF_X.js\":\"1326a331c14d3f3b45c33575eceebbfc93b31c258ea82908b744d8c0961806eb\",\"assets/index-C0xihm3K.js\":\"c3a5465928f81b10c7f55a650b4a3424de0691dc26fa13a05de6681514695d16\",\"assets/index-DWdO08Zv.css\":\"0cd8bc74e233b4a804728e823f79b07fd598f349fd123c2d8f28fb5db89f60d2\",\"assets/manage-zniVaOXi.js\":\"7dd28c7dd541dd93213473d5c3c0ba48882897a40c9e17d243b57289736c6033\",\"assets/model-BhDZKaW7.css\":\"6c5740c3b5ac779d9bac281576b4fbb48c5da54a165bce2a4712f8052b110d74\",\"assets/model-Cel5Rh_E.js\":\"1ea7e1530fb778785538b782e4531cf725974a0fd6738dbd5e700c073f2942b7\",\"assets/news-D2HLdHTW.js\":\"3454b3b611aa711b49cccbad4d7e9d7fec7cb7cfb51389ca55a2f857e62e9a2b\",\"assets/parts-BNrl7y2p.js\":\"ad91c8515db60eab7486d56496fd83709cb33d136e9436af2ebe5ec59f9aefb2\",\"assets/saving-DbPjuOQb.js\":\"94d1a2e76767f7fdfe2e444b94c2326a340904bc4ede0b5445dbbf7236821d66\",\"assets/stage-NGPkhkBp.js\":\"1077784b62f59cc6ab7b987e78ed632a6336e471e8faf656d9f8da25ad241f5b\",\"assets/stream-Bf_baSq3.js\":\"e9d672bee3c33f688f66b039ff7b4287df990c5dbcddb364e86a46f90e445aaa\",\"assets/uPlot-CnsZ1jie.css\":\"0fd9465202f6dfceac29e67c17e5ac9fb1b7ba7615c1bb08782391b791d9f1e0\",\"assets/uPlot.esm-BScb58at.js\":\"068506d72590b07d0e53e012ff1541813c52c09bded848b3f97fcd1d4b0fd3b2\",\"favicon.ico\":\"eb66fde2ce87c9f33228184353f8a8c7ff0517cd76eaf9d6a94759bbd7276be9\",\"icon-192.png\":\"df4dde7d57f1963226b36d9501a3b173c02eddc858bef226ae0176dbb4b7ee19\",\"icon-512.png\":\"6e797a05bab65afa3472b6a2bbc42b2f7a33115ab789fa2403c592655657e04d\",\"icon-maskable.png\":\"98caea4e0138a5272161323354bea3585ecac298ff8576823258aeddee01a45f\",\"icon.svg\":\"d12d71c61b9b10bf6b04ba84d91497c272291cd0830c21d5ca98ce2c771fabf2\",\"index.html\":\"4378c7c8e796d8d598a07b9595b03abd7e9f7f61177895aaaa1b5529c681b517\",\"page.webmanifest\":\"909a00587727949215a61974b50bfb8f15bda9c788e30bb4cdae5af19732dc86\"}");
/** What the page itself names: enough to say that the robot is away. */
const SHELL = JSON.parse("[\"index.html\",\"icon.svg\",\"icon-192.png\",\"page.webmanifest\",\"assets/index-C0xihm3K.js\",\"assets/access-B0lmsRTm.js\",\"assets/parts-BNrl7y2p.js\",\"assets/index-DWdO08Zv.css\"]");
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
