// Keeps the page for a robot that is off or far: the files that it was built with, each checked by its digest, and nothing
// else. What the robot says is never kept. The build fills in the names.
const BUILD = "080f7d793e7dbd82";
/** @type {Record<string, string>} */
const FILES = JSON.parse("{\"assets/Behaviours-CW6UGM9H.css\":\"f8ec05f55e6ffeb2c0ecf622c8f86b9bcd1e9fc4197c1fb4ed8135c322d9d1a4\",\"assets/Behaviours-xjn0utSB.js\":\"8b46db72a7fd3feed84fde101e312aa9db5f7837b99ef6e0112d59e725c20f86\",\"assets/Below-C-xJ5FUL.js\":\"00c66ad249f4183d4e77b0edcb821d1fcc36bd3e2ea062ef4486bf560337d48a\",\"assets/Call-BH-FlvRt.css\":\"72c27a044611bd5e73568c62521730576fefce8c2a7bc35fb38ab268f89da215\",\"assets/Call-CiDYYN6j.js\":\"16136db6be43a2cc94e0579ef542154153b81c3829c1133d60d6520a749946ba\",\"assets/Display-C_kYYi92.js\":\"e48267c09503826f860f6d8d7c66f33fc083a6fad8b6eeb68f8cbe51334e793f\",\"assets/Display-hbDRwTTd.css\":\"c83eeecb550859a06b9cd577a58e8c226d9ef24d37e0f7fb05ec1f901b52e67e\",\"assets/Drive-AIac3ibv.js\":\"014becc82e9313b669111facc104b01b635fbf2f6b633a752101d8a5cc519ee4\",\"assets/Drive-SXBgoOJe.css\":\"952ea49eb711e00149d18e0c99129d41b137d2050350054166a85c0ca5f02a5a\",\"assets/Joints-DSFQRiaw.js\":\"0b793119a991f6a1cfe2cb479b11a7eb2d161736f1a031e94416de981214dbc2\",\"assets/Lacking-COWqCLU0.js\":\"e201b28a4d496417b4a9aea3d479a71fe5760a554cb1caf8cf376d96451dfc05\",\"assets/Lacking-CacvYTQJ.css\":\"c7c4f4a3d3af03716a518f6da6ec94b34d1ffc67385869d3316d0f32ce4ddef3\",\"assets/Log-BXuyXooy.js\":\"645b6bdada66f511bd2c6445de2847d564daa3749798eb9dd733393bc52cc988\",\"assets/Motions-7JeBtcG_.js\":\"6a9f54de82b145c1b5f53904a3a2886fb08c3e42ddfc98c533c2f8d4ffe40d5a\",\"assets/Motions-_yckXxin.css\":\"2433d9b632a30f7a464cc23593c6e0c8506e1ef700457cbf68b5345c87be19b0\",\"assets/System-CAGU8Dof.css\":\"ae933e9c36299104bd16c32c77243303a9aac415f91195177bf4a3e59a11cf9e\",\"assets/System-dbBocnun.js\":\"b211fb2b6578e868b82a8ba653c84ac35b3140db73eff696f0c7ec52776655c2\",\"assets/access-BFjq4TgM.js\":\"2a6baf419783455d3d827125d039df70d6d2e9ed3be6799f5e8fae08afa49ba8\",\"assets/connection-DXk-nleZ.js\":\"dc99ef35e3caafe880644972990a0948444dd1854c1192fc72cfa50c573dde06\",\"assets/index-DKCBlRWX.js\":\"3c3e152e34842a9b558ac7818934a6e4b4ddf2d90ba78fe546b4686fb1e0bd69\",\"assets/index-rgPNC9JQ.css\":\"6e987d1248cd631b44fec0b2c75cfec3cf0bbffa5a8c100e09ed122d764986fb\",\"assets/manage-CY9cUJ2_.js\":\"03cf4ea74cf084b37f8295dbecd99caa1f7a451b21046a69a5891f248f74ace6\",\"assets/model-CL93qGdx.js\":\"f827d2ed9dfeb5e1f48cdd3c0cea50ebba14a600b79fa2613ab5583ed3ed940d\",\"assets/model-CMAz8ww4.css\":\"c9fe444ef8f066b62dad2319c01061ec5b3b38bb022661d5843cf0ffe2294db4\",\"assets/news-C5IGVO4a.js\":\"f5022c0fa3a2b9d3a62e466fdd2b4e7d0d182a94da60d59dbc0d3738bc1f5bf3\",\"assets/parts-DZNSRyhm.js\":\"5d872d3d5224eea512790d8984b9207406cde3831768a1a2b2e0f26af6656d8b\",\"assets/saving-DbPjuOQb.js\":\"94d1a2e76767f7fdfe2e444b94c2326a340904bc4ede0b5445dbbf7236821d66\",\"assets/stage-BB4keCNE.js\":\"1e7a028365461d2aed3f1f6a54c269e6d8cab5b0041a7a5c84ee18ccf9f466f0\",\"assets/stream-BVb69qoi.js\":\"62897a69d997fd587c536ab9e627cf843ff21f6d0d38750575da3ab0684c727c\",\"assets/uPlot-CnsZ1jie.css\":\"0fd9465202f6dfceac29e67c17e5ac9fb1b7ba7615c1bb08782391b791d9f1e0\",\"assets/uPlot.esm-BScb58at.js\":\"068506d72590b07d0e53e012ff1541813c52c09bded848b3f97fcd1d4b0fd3b2\",\"favicon.ico\":\"eb66fde2ce87c9f33228184353f8a8c7ff0517cd76eaf9d6a94759bbd7276be9\",\"icon-192.png\":\"df4dde7d57f1963226b36d9501a3b173c02eddc858bef226ae0176dbb4b7ee19\",\"icon-512.png\":\"6e797a05bab65afa3472b6a2bbc42b2f7a33115ab789fa2403c592655657e04d\",\"icon-maskable.png\":\"98caea4e0138a5272161323354bea3585ecac298ff8576823258aeddee01a45f\",\"icon.svg\":\"d12d71c61b9b10bf6b04ba84d91497c272291cd0830c21d5ca98ce2c771fabf2\",\"index.html\":\"8d0781510d6d46556fe526bc00c72550958c40c2278d6f670d59cf186ae6c745\",\"page.webmanifest\":\"909a00587727949215a61974b50bfb8f15bda9c788e30bb4cdae5af19732dc86\"}");
/** What the page itself names: enough to say that the robot is away. */
const SHELL = JSON.parse("[\"index.html\",\"icon.svg\",\"icon-192.png\",\"page.webmanifest\",\"assets/index-DKCBlRWX.js\",\"assets/access-BFjq4TgM.js\",\"assets/parts-DZNSRyhm.js\",\"assets/index-rgPNC9JQ.css\"]");
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
