// Keeps the page for a robot that is off or far: the files that it was built with, each checked by its digest, and nothing
// else. What the robot says is never kept. The build fills in the names.
const BUILD = "f5ff43dddc62b0ae";
/** @type {Record<string, string>} */
const FILES = JSON.parse("{\"assets/Behaviours-CW6UGM9H.css\":\"f8ec05f55e6ffeb2c0ecf622c8f86b9bcd1e9fc4197c1fb4ed8135c322d9d1a4\",\"assets/Behaviours-IR4ZmMql.js\":\"840f1b76157815218de458fdb8f7b71508b5c2bc4651d5b29d33f517cb17c234\",\"assets/Call-BH-FlvRt.css\":\"72c27a044611bd5e73568c62521730576fefce8c2a7bc35fb38ab268f89da215\",\"assets/Call-DQwu8JA-.js\":\"e3e339d696ae56c6cd146493cc9c3a75a5e1ec5035f999210c7b1cdf024c336f\",\"assets/Display-BMavbMjG.js\":\"a6ec60b8e7651857cac51125eccdee444aa9985e1f8c6d203d339bf73edd752a\",\"assets/Display-hbDRwTTd.css\":\"c83eeecb550859a06b9cd577a58e8c226d9ef24d37e0f7fb05ec1f901b52e67e\",\"assets/Drive-Bn6g9QZV.js\":\"93651b1d4882b06d073d0f86abcfe4fdda0c5faecff9a4389a774e5e0c5512f3\",\"assets/Drive-Dn8U9ubT.css\":\"343561370078a2e21f41db78ad043c1ec0f0db8ff4fb70abeee241a051d6d477\",\"assets/Joints-CSWz2lZ7.js\":\"153c50ec19cf838dd0c6d817b1121d6b415d32944ab1e11deb739be96e995197\",\"assets/Lacking-CacvYTQJ.css\":\"c7c4f4a3d3af03716a518f6da6ec94b34d1ffc67385869d3316d0f32ce4ddef3\",\"assets/Lacking-T_YNE921.js\":\"ec18a4f11f46d9ba965e73f9cc7386116ecd78a593f117749091d94231327cb3\",\"assets/Log-Ds9CQ-GO.js\":\"24b5c1eb48123c6ccf585227e60a0987087dbfd1ae9b4f44d2c6c1278aa98cca\",\"assets/Motions-CjopR8jm.css\":\"f2dbefb712dec8d10730c54e2d9f27031746dab5cbd6f90c4809dab64658ee20\",\"assets/Motions-Cx8715oo.js\":\"afd0bfbb6cbe94ccd3a791a6b89ac2f3119ba7c392280090613d09db299cf0da\",\"assets/System-Byz79CXU.css\":\"b09219fcd4932b983e1310e1c6efa4b5cb28b8977085ba9db51545cd4203bf3a\",\"assets/System-CVY1Bdyt.js\":\"62bb469fd8813bc7401cd4ab036fc54f7eda03dce080dfa051a749ed830e510d\",\"assets/index-D0PKDC32.js\":\"01726185d452fca5d4d867399f413cf432ea46e4133d4239fd26a3a4c66f6f05\",\"assets/index-rgPNC9JQ.css\":\"6e987d1248cd631b44fec0b2c75cfec3cf0bbffa5a8c100e09ed122d764986fb\",\"assets/manage-D3YqutBs.js\":\"589dc2320f6999c2e2bd6ac2ce10f8b749fbc6c88183d89584c8199d4fb81c44\",\"assets/model-BOdhXyAZ.js\":\"9990d264fafe89b1b51bcd7b839cb234e30a761306874ff63e8c84fc26c8e0d1\",\"assets/model-DHXowZ_C.css\":\"ec960a47eec173c0a883112abe447603ac0f4e9b3603cd472118936ad0120b59\",\"assets/news-5bYTtgGm.js\":\"e4faa4a87325036236849c7ca88dbc5c8490234cc332dc226983e2d829ca045f\",\"assets/parts-Ct5C6r0z.js\":\"cec710ad0c1b394bf5cda8ea37e3c77b750b838bb4c253638faeaabb1546be38\",\"assets/saving-DbPjuOQb.js\":\"94d1a2e76767f7fdfe2e444b94c2326a340904bc4ede0b5445dbbf7236821d66\",\"assets/stage-CbsJBrhJ.js\":\"8335074d2807cf2560315abb6540cbac0935e201e1124fc027a811c5bed77eb8\",\"assets/stream-DaPtPUUY.js\":\"7e10e8d62c24947f923f87a80a9d9d94879e00b4a37ed95275397f5bac6b2f03\",\"assets/uPlot-CnsZ1jie.css\":\"0fd9465202f6dfceac29e67c17e5ac9fb1b7ba7615c1bb08782391b791d9f1e0\",\"assets/uPlot.esm-BScb58at.js\":\"068506d72590b07d0e53e012ff1541813c52c09bded848b3f97fcd1d4b0fd3b2\",\"favicon.ico\":\"eb66fde2ce87c9f33228184353f8a8c7ff0517cd76eaf9d6a94759bbd7276be9\",\"icon-192.png\":\"df4dde7d57f1963226b36d9501a3b173c02eddc858bef226ae0176dbb4b7ee19\",\"icon-512.png\":\"6e797a05bab65afa3472b6a2bbc42b2f7a33115ab789fa2403c592655657e04d\",\"icon-maskable.png\":\"98caea4e0138a5272161323354bea3585ecac298ff8576823258aeddee01a45f\",\"icon.svg\":\"d12d71c61b9b10bf6b04ba84d91497c272291cd0830c21d5ca98ce2c771fabf2\",\"index.html\":\"53ae692310d7a8c2dd54e1bd61b37b08903bf82b4151b28edfc1c223697170b8\",\"page.webmanifest\":\"909a00587727949215a61974b50bfb8f15bda9c788e30bb4cdae5af19732dc86\"}");
/** What the page itself names: enough to say that the robot is away. */
const SHELL = JSON.parse("[\"index.html\",\"icon.svg\",\"icon-192.png\",\"page.webmanifest\",\"assets/index-D0PKDC32.js\",\"assets/parts-Ct5C6r0z.js\",\"assets/index-rgPNC9JQ.css\"]");
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
