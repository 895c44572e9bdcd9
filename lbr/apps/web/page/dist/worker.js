// Keeps the page for a robot that is off or far: the files that it was built with, each checked by its digest, and nothing
// else. What the robot says is never kept. The build fills in the names.
const BUILD = "7e3f59cc943d39df";
/** @type {Record<string, string>} */
const FILES = JSON.parse("{\"assets/Behaviours-CLyRV6ic.js\":\"0056c99ab3ccb9ad88c036643cac7165191797da3629ecb151c32f0545897c78\",\"assets/Behaviours-CW6UGM9H.css\":\"f8ec05f55e6ffeb2c0ecf622c8f86b9bcd1e9fc4197c1fb4ed8135c322d9d1a4\",\"assets/Call-BH-FlvRt.css\":\"72c27a044611bd5e73568c62521730576fefce8c2a7bc35fb38ab268f89da215\",\"assets/Call-DozFfq_q.js\":\"02a6ef1d5d70bb82dfc830b91b0ae684b0d1223f2dca9e9fe3b902b048d6ad4b\",\"assets/Display-DC2neopA.js\":\"434bc28f4dd98eca07dddfd7a58817b2279efb0edc58c8ade7fd5e0da73aaff6\",\"assets/Display-hbDRwTTd.css\":\"c83eeecb550859a06b9cd577a58e8c226d9ef24d37e0f7fb05ec1f901b52e67e\",\"assets/Drive-4osGqLV4.css\":\"068027e6e3fb156d06aa1ca17041a0e63f7ca8ffd7c579b59c58e6deb0f9802e\",\"assets/Drive-BDFETS8B.js\":\"9803a4e998fab006034e6f42efd2bf94e941dd2052a648746d480a5f9d2553a2\",\"assets/Joints-DnQyRDy2.js\":\"dcf6846ef38e22df0978dd097604007bc4f50842b632fa40a029653976049c05\",\"assets/Lacking-DcaWisd4.css\":\"20ccff9ae77390d0ffa2d5a4e4fcc5080d4034f4303230550f0ca2a66e35a8d0\",\"assets/Lacking-HqvTtzrs.js\":\"df95d9161b4c6418b9e56c598729599793bf83ddde03709c51e51c41edb96166\",\"assets/Log-Bzn6GvE1.js\":\"5e107c8cd17b939d3b5e186cdc1d37fd0ea2c07dde9531bd180f0a5335bd15a6\",\"assets/Motions-CxnOFEXi.css\":\"8469f628155c6a1a826a2877357a72e019e19b21b42a7ff3ae0a2bc7d31cb181\",\"assets/Motions-DuGAh8Sd.js\":\"7d3193844b42820218af740ea30db6881711433bb1995c5979e35c29782eed75\",\"assets/System-BBAojJCY.css\":\"6c3cde3deca887ae7047e53b92420cf0d267a45161e3bf596685f63bd55a5fa7\",\"assets/System-BllzXIJ8.js\":\"e0269ac64a23e96598f61e30331159a38ed28902f4adecd7bc0a95d56964273f\",\"assets/index-CS2NsqJf.js\":\"085aed9a7e7d00832f835ab2c01193c078b67aaefe3cbe286763c970ed9d013c\",\"assets/index-DmsQZcft.css\":\"45845ee9f02c1569fe3fc8bc001bacf7e541337518e36b69c9ece31d2d68a32b\",\"assets/manage-cUxUgIyl.js\":\"3956ecbcba2456edcd9a4eaca08b20247f9cf5154939bfaf218a6f654e9e6fa0\",\"assets/model-BLl1PMjy.js\":\"21e430bae235731d8313c791b90dfe85db72dca1a3661f8292fd0f45cc6b6ca7\",\"assets/model-DHXowZ_C.css\":\"ec960a47eec173c0a883112abe447603ac0f4e9b3603cd472118936ad0120b59\",\"assets/news-D561L2e0.js\":\"8846616b88be1ba1141876eca36bfa975283796fac1f39158a9f160bc51480c7\",\"assets/parts-PxxFqgB7.js\":\"0536c4dfbe8710e424ed3b6ed8f979e162aba8bbaed2acee3dc2eb516beb32c0\",\"assets/saving-DbPjuOQb.js\":\"94d1a2e76767f7fdfe2e444b94c2326a340904bc4ede0b5445dbbf7236821d66\",\"assets/stage-TlnnQRba.js\":\"7cbaafd312910989b8c8a6eeb3f006fbc64a83fc7c60c33822e98a29f987d48e\",\"assets/stream-D62Fd1l3.js\":\"c6039bd87631327fc81b55e1b048e92b6e3441adf89c306d4b399cea210ceb1f\",\"assets/uPlot-CnsZ1jie.css\":\"0fd9465202f6dfceac29e67c17e5ac9fb1b7ba7615c1bb08782391b791d9f1e0\",\"assets/uPlot.esm-BScb58at.js\":\"068506d72590b07d0e53e012ff1541813c52c09bded848b3f97fcd1d4b0fd3b2\",\"favicon.ico\":\"eb66fde2ce87c9f33228184353f8a8c7ff0517cd76eaf9d6a94759bbd7276be9\",\"icon-192.png\":\"df4dde7d57f1963226b36d9501a3b173c02eddc858bef226ae0176dbb4b7ee19\",\"icon-512.png\":\"6e797a05bab65afa3472b6a2bbc42b2f7a33115ab789fa2403c592655657e04d\",\"icon-maskable.png\":\"98caea4e0138a5272161323354bea3585ecac298ff8576823258aeddee01a45f\",\"icon.svg\":\"d12d71c61b9b10bf6b04ba84d91497c272291cd0830c21d5ca98ce2c771fabf2\",\"index.html\":\"2b2daad549cba11dce94f5b84567fc912fb248d2114be5aa1dc5585fd2eebe5d\",\"page.webmanifest\":\"909a00587727949215a61974b50bfb8f15bda9c788e30bb4cdae5af19732dc86\"}");
/** What the page itself names: enough to say that the robot is away. */
const SHELL = JSON.parse("[\"index.html\",\"icon.svg\",\"icon-192.png\",\"page.webmanifest\",\"assets/index-CS2NsqJf.js\",\"assets/parts-PxxFqgB7.js\",\"assets/index-DmsQZcft.css\"]");
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
