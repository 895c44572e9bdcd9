// Keeps the page for a robot that is off or far: the files that it was built with, each checked by its digest, and nothing
// else. What the robot says is never kept. The build fills in the names.
const BUILD = "03fbf04d477109a9";
/** @type {Record<string, string>} */
const FILES = JSON.parse("{\"assets/Behaviours-CW6UGM9H.css\":\"f8ec05f55e6ffeb2c0ecf622c8f86b9bcd1e9fc4197c1fb4ed8135c322d9d1a4\",\"assets/Behaviours-CxzUf635.js\":\"36b46513052f3bec87be286b82e2132d398efb7661a14fc176460c3ba6861547\",\"assets/Call-BH-FlvRt.css\":\"72c27a044611bd5e73568c62521730576fefce8c2a7bc35fb38ab268f89da215\",\"assets/Call-BorUMuOq.js\":\"3df5ef9bcf3d1e14a4bc96cfd73553be80378a76aa59f825f0101c7e04d10035\",\"assets/Display-CgzXSYmH.js\":\"c14c139b53d287d8e7d0d10112b4dc9d900ea0c591f32df30f90f502ac3a97b5\",\"assets/Display-hbDRwTTd.css\":\"c83eeecb550859a06b9cd577a58e8c226d9ef24d37e0f7fb05ec1f901b52e67e\",\"assets/Drive-BkT_RXnU.js\":\"416a4e137590a42339dbc5d08cb00f54b316f43cc7db8c80b364d354f2cda2fc\",\"assets/Drive-CiuoIAbs.css\":\"17805b96ada40ebf1ed073494d6679ba715eba850c1f7641880a94b0ba449301\",\"assets/Joints-DQeNAHvu.js\":\"39a12e9d7f6d8d39b963c8ecc5ad27b0ef5353a369d72d12f924c76a68cf2e9a\",\"assets/Motions-2ZoZ29LK.js\":\"c3e1d6142b97397379c5546d88f32f34ef5c86f6f42e0c361562f26c885c335f\",\"assets/Motions-DTmtowIs.css\":\"74f4e85481e71bfcd588edda731de4d747c10ec024662e83369e4c350bc0b733\",\"assets/System-C4ZGDI-e.js\":\"f2d8d710a7ee251e8ea1373cfd85503745fdc32fde2ecaa715f3e9e268d95959\",\"assets/System-Ch8fGQsc.css\":\"fe06b79534e407e0432e52ba5808c4cebb856c5ff634453639f100622e75b71f\",\"assets/index-BV7VRDOR.css\":\"01bdf9f86384360d14e501bd44e68f87b0c803cdc82a63e2a23de5670bb51a2f\",\"assets/index-FUmHH_WF.js\":\"563c428dab461990a012ac3b4cc7b98cc0ec3f7604dd7625ed4cdf42b7590b15\",\"assets/manage-DLOVLLkS.js\":\"c49d29890b650d93a56424b6e86c1e908d44be9a174042b7fa5152821c5f91e5\",\"assets/model-Bx7yEgVu.css\":\"802b384b1a54f70974f60851ef6bb609817b19f6c569ccb15816cb9f8a7b4e9f\",\"assets/model-aNfNC5N4.js\":\"3fd502ca7b8dd62c7b5182f5cf64312b26d966469df7437f1c9441c8cf78a30a\",\"assets/parts-kCGYmh1f.js\":\"5dae6741ffe1c554e76d7343e8e49070eba7fa3093007f8b84233c769234289e\",\"assets/saving-DbPjuOQb.js\":\"94d1a2e76767f7fdfe2e444b94c2326a340904bc4ede0b5445dbbf7236821d66\",\"assets/stage-BfHgqFyX.js\":\"ba332c18a1494ec4ace456517569945810407543976c029bf7e2f1c277bb3482\",\"assets/stream-CdHc_J4p.js\":\"029c93590f0aad664e9495f2d27ee220b3f56d37f052bcea051b2aeeb05ac8d2\",\"assets/uPlot-CnsZ1jie.css\":\"0fd9465202f6dfceac29e67c17e5ac9fb1b7ba7615c1bb08782391b791d9f1e0\",\"assets/uPlot.esm-BScb58at.js\":\"068506d72590b07d0e53e012ff1541813c52c09bded848b3f97fcd1d4b0fd3b2\",\"icon-192.png\":\"df4dde7d57f1963226b36d9501a3b173c02eddc858bef226ae0176dbb4b7ee19\",\"icon-512.png\":\"6e797a05bab65afa3472b6a2bbc42b2f7a33115ab789fa2403c592655657e04d\",\"icon-maskable.png\":\"98caea4e0138a5272161323354bea3585ecac298ff8576823258aeddee01a45f\",\"icon.svg\":\"d12d71c61b9b10bf6b04ba84d91497c272291cd0830c21d5ca98ce2c771fabf2\",\"index.html\":\"a3b29305d6ac0f864f88d8d74f67df26e80c744900ae6d3239f856c38dd16881\",\"page.webmanifest\":\"909a00587727949215a61974b50bfb8f15bda9c788e30bb4cdae5af19732dc86\"}");
/** What the page itself names: enough to say that the robot is away. */
const SHELL = JSON.parse("[\"index.html\",\"icon.svg\",\"icon-192.png\",\"page.webmanifest\",\"assets/index-FUmHH_WF.js\",\"assets/parts-kCGYmh1f.js\",\"assets/index-BV7VRDOR.css\"]");
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
