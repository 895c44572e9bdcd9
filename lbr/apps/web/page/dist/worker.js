// Keeps the page for a robot that is off or far: the files that it was built with, each checked by its digest, and nothing
// else. What the robot says is never kept. The build fills in the names.
const BUILD = "7fbc1147761501f4";
/** @type {Record<string, string>} */
const FILES = JSON.parse("{\"assets/Behaviours-CBfc3tMU.js\":\"9400411ac47969cb576e1f327709cd88d2be0a55a4f67b99618ba4354c12baf7\",\"assets/Behaviours-CW6UGM9H.css\":\"f8ec05f55e6ffeb2c0ecf622c8f86b9bcd1e9fc4197c1fb4ed8135c322d9d1a4\",\"assets/Call-BH-FlvRt.css\":\"72c27a044611bd5e73568c62521730576fefce8c2a7bc35fb38ab268f89da215\",\"assets/Call-BZ1P_3LY.js\":\"3fa2eed9e56f1f6779ec2d9b14fee6f87d65d6e666ccf3fb2caa2ff6076deb8a\",\"assets/Display-D_Jid0Ah.js\":\"127a1b4c7398e022c865772a9e6e2df33b8af1d61a3385da37b26fbe1ed9f895\",\"assets/Display-hbDRwTTd.css\":\"c83eeecb550859a06b9cd577a58e8c226d9ef24d37e0f7fb05ec1f901b52e67e\",\"assets/Drive-4osGqLV4.css\":\"068027e6e3fb156d06aa1ca17041a0e63f7ca8ffd7c579b59c58e6deb0f9802e\",\"assets/Drive-CTf1yR0z.js\":\"4a4177bb8fd015b8fbbd8902f73286c97b7c3d756cf8464454cc57c5b787823d\",\"assets/Joints-Zf0jiCE7.js\":\"86dd6b4ff63b47863eb392fb9c033ef38ca50e33d8eb550e31aec1de524ced0a\",\"assets/Motions-CxnOFEXi.css\":\"8469f628155c6a1a826a2877357a72e019e19b21b42a7ff3ae0a2bc7d31cb181\",\"assets/Motions-PC_PB75h.js\":\"0b7c3762bace0ac29403bd3176a10cc119ce6b50e859113d7e1deee75c8f4a41\",\"assets/System-D-VKYm84.css\":\"00770ab6c350eab1e1268a2e7b671bded9ea003dcbb92472b016dd805c05ad6e\",\"assets/System-DTmrXgjT.js\":\"8687c4e62802794668c542efd1789c38049cb4860185a2c002cf12b980b688c5\",\"assets/index-DdppZgW8.js\":\"5cb1634aa89be9a2726c9e7a0a5f75995da535bf8349faf7ca9199be5a246180\",\"assets/index-DmsQZcft.css\":\"45845ee9f02c1569fe3fc8bc001bacf7e541337518e36b69c9ece31d2d68a32b\",\"assets/manage-ChuwnC8n.js\":\"c828c82bb16d51d7747633794650478a1ca6fe5c88ac979cf419d020976b7a01\",\"assets/model-BlFSRRz7.js\":\"d5599b08b80c269db9ba50229504b5f6a4fe9ab4889ab0749c0f885af9f4ec46\",\"assets/model-DHXowZ_C.css\":\"ec960a47eec173c0a883112abe447603ac0f4e9b3603cd472118936ad0120b59\",\"assets/news-CvMvTBzv.js\":\"ff9098ab7722f74a098df5e98a6411b8ce414feb1f06825cedbfadd50647f3d1\",\"assets/parts-pBIPFoDe.js\":\"9f5a9e268b71dfc1c3eab3dc9b85e7248fca0e92f18cb50079ec8645b5cb89c1\",\"assets/saving-DbPjuOQb.js\":\"94d1a2e76767f7fdfe2e444b94c2326a340904bc4ede0b5445dbbf7236821d66\",\"assets/stage-CAIAdha8.js\":\"4c5ddc5d673adcd36d6b595f652e84ef21411ae3978ba036c701f511a745ab3b\",\"assets/stream-DDXjUSaG.js\":\"4064035cc05bd873e56eb021b4d01d5576423781dcb8daa923f203fe1e83ea8e\",\"assets/uPlot-CnsZ1jie.css\":\"0fd9465202f6dfceac29e67c17e5ac9fb1b7ba7615c1bb08782391b791d9f1e0\",\"assets/uPlot.esm-BScb58at.js\":\"068506d72590b07d0e53e012ff1541813c52c09bded848b3f97fcd1d4b0fd3b2\",\"favicon.ico\":\"eb66fde2ce87c9f33228184353f8a8c7ff0517cd76eaf9d6a94759bbd7276be9\",\"icon-192.png\":\"df4dde7d57f1963226b36d9501a3b173c02eddc858bef226ae0176dbb4b7ee19\",\"icon-512.png\":\"6e797a05bab65afa3472b6a2bbc42b2f7a33115ab789fa2403c592655657e04d\",\"icon-maskable.png\":\"98caea4e0138a5272161323354bea3585ecac298ff8576823258aeddee01a45f\",\"icon.svg\":\"d12d71c61b9b10bf6b04ba84d91497c272291cd0830c21d5ca98ce2c771fabf2\",\"index.html\":\"cd91e30d99b8a3fce9a21883d7a0c5221dd37cc4a6a1b7618e93921abfb9ee18\",\"page.webmanifest\":\"909a00587727949215a61974b50bfb8f15bda9c788e30bb4cdae5af19732dc86\"}");
/** What the page itself names: enough to say that the robot is away. */
const SHELL = JSON.parse("[\"index.html\",\"icon.svg\",\"icon-192.png\",\"page.webmanifest\",\"assets/index-DdppZgW8.js\",\"assets/parts-pBIPFoDe.js\",\"assets/index-DmsQZcft.css\"]");
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
