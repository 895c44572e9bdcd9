// Keeps the page for a robot that is off or far: the files that it was built with, each checked by its digest, and nothing
// else. What the robot says is never kept. The build fills in the names.
const BUILD = "82bfa80fd575a37b";
/** @type {Record<string, string>} */
const FILES = JSON.parse("{\"assets/Behaviours-BBxJKWN_.js\":\"775fd9a31fa2598a6f985363fa6c1e3663952639c36627219d88148425c33d33\",\"assets/Behaviours-CW6UGM9H.css\":\"f8ec05f55e6ffeb2c0ecf622c8f86b9bcd1e9fc4197c1fb4ed8135c322d9d1a4\",\"assets/Call-BH-FlvRt.css\":\"72c27a044611bd5e73568c62521730576fefce8c2a7bc35fb38ab268f89da215\",\"assets/Call-C2L-E_ci.js\":\"2c854769c4dd40dba849c04943dbaee9e297058e3ff1472d1625fecd9dfb572c\",\"assets/Display-DrLlU9S7.js\":\"aead06cffa5757261d21a6b085ac00339d7b10fc6150a68d2cd644e4091f5f9e\",\"assets/Display-hbDRwTTd.css\":\"c83eeecb550859a06b9cd577a58e8c226d9ef24d37e0f7fb05ec1f901b52e67e\",\"assets/Drive-C8Tq45Zd.css\":\"08011867db62c8cb3b9c12a4042ef6bb9ec597d6a95f74b6b314a7d790941e10\",\"assets/Drive-CT_XrJ1q.js\":\"80b698c73627556dc37680d145f3dfa8d495839d9f27dd1c1f127d681ae6e992\",\"assets/Joints-NXoHq0ZE.js\":\"55e5bb11d53ebeaa52c5f21dfbae3a7ab8d56f213cd857c849505932878cc189\",\"assets/Motions-CoUeG6QQ.css\":\"c7405ed80447ef97051d5de59d8b24ad9cce70b4956e89b2333a1e4c142f4c38\",\"assets/Motions-sK3QBJ7H.js\":\"2b349114cdc0f2a60e88f872d3c0c0565a0e14eb7d3dd605dfdff07edf520212\",\"assets/System-B2rcK-iy.js\":\"bd5fff5bb30b45f8902d4150ce14a30850914048563f50737821917ee8124d92\",\"assets/System-xJZzRxg6.css\":\"2d83ae9f9a033c027a167077f5d405b0a8a9e40b97a28f57c7d6949cb04c1462\",\"assets/index-CsU-RWMr.js\":\"8bc5aa12049a9ebd77234f2ccb74cbfe748166611fbde6fd6317f357557472e2\",\"assets/index-DIAhJi-2.css\":\"d0e765591aba08caf1fe52118718837f19e698789e9e691ba5b71b02e6cde5be\",\"assets/manage-tKPG3_QE.js\":\"cdc23c91aa9f173a1bd6059a21e6e52de3cf528e88ac9a091938c6a7bf5243c7\",\"assets/model-Bx7yEgVu.css\":\"802b384b1a54f70974f60851ef6bb609817b19f6c569ccb15816cb9f8a7b4e9f\",\"assets/model-Cy9NkYXA.js\":\"cd5acd3c9be30caff6c8449acd2b44282758623ae051c2cbe598e510349f00a6\",\"assets/news-CmhpNviH.js\":\"b0bf89093e49e10c8928fdfa93eadd062461862cf29a238590f4d62651ad0e3b\",\"assets/parts-D-p-qUhU.js\":\"0fe41756ba33f530f46416f2336931d6d2044800c8ba596979753c8ea4bc102a\",\"assets/saving-DbPjuOQb.js\":\"94d1a2e76767f7fdfe2e444b94c2326a340904bc4ede0b5445dbbf7236821d66\",\"assets/stage-B2-72_1V.js\":\"6166059ec64014349fd80d41a43a0d8aaeebc55eab69cef055edee3ce0ea1945\",\"assets/stream-Dag-XunJ.js\":\"2ca30309061d6850fefcd773fca734f198dda37f2fc9765c50a22e238ae8c6de\",\"assets/uPlot-CnsZ1jie.css\":\"0fd9465202f6dfceac29e67c17e5ac9fb1b7ba7615c1bb08782391b791d9f1e0\",\"assets/uPlot.esm-BScb58at.js\":\"068506d72590b07d0e53e012ff1541813c52c09bded848b3f97fcd1d4b0fd3b2\",\"favicon.ico\":\"eb66fde2ce87c9f33228184353f8a8c7ff0517cd76eaf9d6a94759bbd7276be9\",\"icon-192.png\":\"df4dde7d57f1963226b36d9501a3b173c02eddc858bef226ae0176dbb4b7ee19\",\"icon-512.png\":\"6e797a05bab65afa3472b6a2bbc42b2f7a33115ab789fa2403c592655657e04d\",\"icon-maskable.png\":\"98caea4e0138a5272161323354bea3585ecac298ff8576823258aeddee01a45f\",\"icon.svg\":\"d12d71c61b9b10bf6b04ba84d91497c272291cd0830c21d5ca98ce2c771fabf2\",\"index.html\":\"db3763517666b65bd4ee07e20857b2798c5ea0850c6252ebbb5998330b3246e3\",\"page.webmanifest\":\"909a00587727949215a61974b50bfb8f15bda9c788e30bb4cdae5af19732dc86\"}");
/** What the page itself names: enough to say that the robot is away. */
const SHELL = JSON.parse("[\"index.html\",\"icon.svg\",\"icon-192.png\",\"page.webmanifest\",\"assets/index-CsU-RWMr.js\",\"assets/parts-D-p-qUhU.js\",\"assets/index-DIAhJi-2.css\"]");
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
