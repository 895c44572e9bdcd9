// Keeps the page for a robot that is off or far: the files that it was built with, each checked by its digest, and nothing
// else. What the robot says is never kept. The build fills in the names.
const BUILD = "be21094524591236";
/** @type {Record<string, string>} */
const FILES = JSON.parse("{\"assets/Behaviours-COVt1b99.js\":\"ba52938daff7cb4772ec657370d09184714f7e68f804498a26e47812b0d01452\",\"assets/Behaviours-CW6UGM9H.css\":\"f8ec05f55e6ffeb2c0ecf622c8f86b9bcd1e9fc4197c1fb4ed8135c322d9d1a4\",\"assets/Call-BH-FlvRt.css\":\"72c27a044611bd5e73568c62521730576fefce8c2a7bc35fb38ab268f89da215\",\"assets/Call-BStRTj1X.js\":\"dd0534aad0ae26d33dc42cc67df2a6b7b7a5b32f5da305ed957712901b47f233\",\"assets/Display-CE7iNZct.js\":\"3f7d0bf16980b6de2b43087d563f34ffbfd9e69107ba39dca74d5385acae7891\",\"assets/Display-hbDRwTTd.css\":\"c83eeecb550859a06b9cd577a58e8c226d9ef24d37e0f7fb05ec1f901b52e67e\",\"assets/Drive-4osGqLV4.css\":\"068027e6e3fb156d06aa1ca17041a0e63f7ca8ffd7c579b59c58e6deb0f9802e\",\"assets/Drive-BUZ6sNc8.js\":\"6a60b39ac7e6d1bcb0b0dae4be68f56560b4df3ba196c30d795ad06d93ba056e\",\"assets/Joints-cld3sAJN.js\":\"e8707dd0d431bfa5c0a0d15cbfbad84ac479af6a499b3f9dc7dc954656d4cd69\",\"assets/Lacking-BM-e8nLm.js\":\"f1857ddb45fec1dc983e8fb044ae29880e694e78411bd210f69fbeef2f99b660\",\"assets/Lacking-CacvYTQJ.css\":\"c7c4f4a3d3af03716a518f6da6ec94b34d1ffc67385869d3316d0f32ce4ddef3\",\"assets/Log-gm3evsga.js\":\"56404ffcc7b4fb46afd9d88d01eb92b9ceaf850587dbd99e7e200b392096c83d\",\"assets/Motions-CxnOFEXi.css\":\"8469f628155c6a1a826a2877357a72e019e19b21b42a7ff3ae0a2bc7d31cb181\",\"assets/Motions-DzCa_gIf.js\":\"318dcd677d9458d78341ed5bad750a036d36b72366e7981b111b27820bd1c43d\",\"assets/System-Byz79CXU.css\":\"b09219fcd4932b983e1310e1c6efa4b5cb28b8977085ba9db51545cd4203bf3a\",\"assets/System-DLC1Bdk8.js\":\"9f2f5cca70f8dbb2cd96a7ee006df06bb74e59062b7b741417af5a21f7d82293\",\"assets/index-Dv9r-hJA.js\":\"db1721947b6754a4464f4bd2b93b5665611d5647b2ad864ea383e2dce81de39e\",\"assets/index-_KY3zcl1.css\":\"ee7fa8614f5a30836f9843d438181568cac59bc9dfa0c9f9f993620a76a79878\",\"assets/manage-BmO3yHP_.js\":\"2a1797c1bd9f8df885ed7b807d7bf310679aaff9d7694e12d2bedbefc72f62af\",\"assets/model-3VJ9jkHG.js\":\"852de43c0cbde938909ddcec04053b0aa5254901508601b55872c84678e72014\",\"assets/model-DHXowZ_C.css\":\"ec960a47eec173c0a883112abe447603ac0f4e9b3603cd472118936ad0120b59\",\"assets/news-DCnWrK01.js\":\"69bac727845c14910b6a155850207a7131f452712fe16d03c66c44d1ffbc369a\",\"assets/parts-Bj1GUPPy.js\":\"3195753d10f78788507e50c888504af434fc80eb17a78768be9080ce0b1e3c2f\",\"assets/saving-DbPjuOQb.js\":\"94d1a2e76767f7fdfe2e444b94c2326a340904bc4ede0b5445dbbf7236821d66\",\"assets/stage-0SAEer9T.js\":\"0777b9d795d022f9418124841b088b6eb68597a232c630b526708d10ffb3ccee\",\"assets/stream-DXjrb0E5.js\":\"0d44f19c5fcab07e568b8d1e548007f89f30be2697973263fcc4224306159488\",\"assets/uPlot-CnsZ1jie.css\":\"0fd9465202f6dfceac29e67c17e5ac9fb1b7ba7615c1bb08782391b791d9f1e0\",\"assets/uPlot.esm-BScb58at.js\":\"068506d72590b07d0e53e012ff1541813c52c09bded848b3f97fcd1d4b0fd3b2\",\"favicon.ico\":\"eb66fde2ce87c9f33228184353f8a8c7ff0517cd76eaf9d6a94759bbd7276be9\",\"icon-192.png\":\"df4dde7d57f1963226b36d9501a3b173c02eddc858bef226ae0176dbb4b7ee19\",\"icon-512.png\":\"6e797a05bab65afa3472b6a2bbc42b2f7a33115ab789fa2403c592655657e04d\",\"icon-maskable.png\":\"98caea4e0138a5272161323354bea3585ecac298ff8576823258aeddee01a45f\",\"icon.svg\":\"d12d71c61b9b10bf6b04ba84d91497c272291cd0830c21d5ca98ce2c771fabf2\",\"index.html\":\"00e3626f177e62a5a367f6d6483d2fa9d80815ec0de82707dd2f75f7c73484f9\",\"page.webmanifest\":\"909a00587727949215a61974b50bfb8f15bda9c788e30bb4cdae5af19732dc86\"}");
/** What the page itself names: enough to say that the robot is away. */
const SHELL = JSON.parse("[\"index.html\",\"icon.svg\",\"icon-192.png\",\"page.webmanifest\",\"assets/index-Dv9r-hJA.js\",\"assets/parts-Bj1GUPPy.js\",\"assets/index-_KY3zcl1.css\"]");
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
