// Keeps the page for a robot that is off or far: the files that it was built with, each checked by its digest, and nothing
// else. What the robot says is never kept. The build fills in the names.
const BUILD = "145ef5f46c96c03d";
/** @type {Record<string, string>} */
const FILES = JSON.parse("{\"assets/Behaviours-CBAu91mS.js\":\"613ad5a02d850ce90273cd699ccbd4e4e9945b823d7a14b55e019690a5056997\",\"assets/Behaviours-CW6UGM9H.css\":\"f8ec05f55e6ffeb2c0ecf622c8f86b9bcd1e9fc4197c1fb4ed8135c322d9d1a4\",\"assets/Call-BH-FlvRt.css\":\"72c27a044611bd5e73568c62521730576fefce8c2a7bc35fb38ab268f89da215\",\"assets/Call-DgwJX7_B.js\":\"b7fef2e14732b4d21cfae7784edbd81fb881e033fc80c21277be204ce939d4a6\",\"assets/Display-CULclgg3.js\":\"d434c3be5f64021cd991cdd27729114ba203e739128e824cff6464b9fb71190b\",\"assets/Display-hbDRwTTd.css\":\"c83eeecb550859a06b9cd577a58e8c226d9ef24d37e0f7fb05ec1f901b52e67e\",\"assets/Drive-DIGngHxu.js\":\"dec7ce37eee1395f3bcaf1282ae102b2318df6e1283531f1b47945edd6c07567\",\"assets/Drive-Dn8U9ubT.css\":\"343561370078a2e21f41db78ad043c1ec0f0db8ff4fb70abeee241a051d6d477\",\"assets/Joints-DuS5VLBk.js\":\"1dbda1f1004d0619329e63e30f07ac6000779fe14c234424254528e26aa06f32\",\"assets/Lacking-CacvYTQJ.css\":\"c7c4f4a3d3af03716a518f6da6ec94b34d1ffc67385869d3316d0f32ce4ddef3\",\"assets/Lacking-CpfYCY4Q.js\":\"8dc8bf880ecd8933c059a5a00f081d84f8d5b6efd8681bce46ad3a67dbc03579\",\"assets/Log-TrYYQh6I.js\":\"a36ff799f8e8c2996184a5f56252ca09c56c6e530304c45ec009e52af5c6dcb9\",\"assets/Motions-CdX9ivUy.js\":\"1535e0dc4cd8b84a57322c9122a561d8948d2d8f18aa8ea524cf2c563544d374\",\"assets/Motions-CjopR8jm.css\":\"f2dbefb712dec8d10730c54e2d9f27031746dab5cbd6f90c4809dab64658ee20\",\"assets/System-Byz79CXU.css\":\"b09219fcd4932b983e1310e1c6efa4b5cb28b8977085ba9db51545cd4203bf3a\",\"assets/System-CEOQF-c7.js\":\"9e2ca9f4b90e89338e01593f075771c095d11f6d0977d744c9177e47777843a8\",\"assets/index-DQT3jTGi.js\":\"287a8ff45c104cbf17c4ed534b2088420b0708727a461a346472d68f6eb58ae1\",\"assets/index-rgPNC9JQ.css\":\"6e987d1248cd631b44fec0b2c75cfec3cf0bbffa5a8c100e09ed122d764986fb\",\"assets/manage-CLIh8F5e.js\":\"7b783f948b492756689c815e82093910fef63f2d2d65dc2759a4552fab64caee\",\"assets/model-BWPWOBcQ.js\":\"f50b0e7c7f7d2171ab7bae7fa3672d023cfa2dc17472cb1821936016722a7cd2\",\"assets/model-wURZCf0a.css\":\"9aaf4c44fdf51be20099e29c6aa4d693e0d571c2935a9cf9327a5ee7dae909e6\",\"assets/news-CWOwXsDA.js\":\"0210e786cf52a4fba1710eecb253eca132a8ec2748dbf1c553dd1ab475518c96\",\"assets/parts-DgmqwHJP.js\":\"8c87e0f718398e089e89f1daa15e2510f1ec8e4aa248551354260287eeb33a9a\",\"assets/saving-DbPjuOQb.js\":\"94d1a2e76767f7fdfe2e444b94c2326a340904bc4ede0b5445dbbf7236821d66\",\"assets/stage-CE4QXg-q.js\":\"84703ee953efc331b32d3d61f6cfbd1629f2d6d222994935fb0d2276525f3793\",\"assets/stream-B0ez0lqP.js\":\"0edde81a3df2f3b935a80b85d1f581a39282888b59920a5a030bd0181f5a1f45\",\"assets/uPlot-CnsZ1jie.css\":\"0fd9465202f6dfceac29e67c17e5ac9fb1b7ba7615c1bb08782391b791d9f1e0\",\"assets/uPlot.esm-BScb58at.js\":\"068506d72590b07d0e53e012ff1541813c52c09bded848b3f97fcd1d4b0fd3b2\",\"favicon.ico\":\"eb66fde2ce87c9f33228184353f8a8c7ff0517cd76eaf9d6a94759bbd7276be9\",\"icon-192.png\":\"df4dde7d57f1963226b36d9501a3b173c02eddc858bef226ae0176dbb4b7ee19\",\"icon-512.png\":\"6e797a05bab65afa3472b6a2bbc42b2f7a33115ab789fa2403c592655657e04d\",\"icon-maskable.png\":\"98caea4e0138a5272161323354bea3585ecac298ff8576823258aeddee01a45f\",\"icon.svg\":\"d12d71c61b9b10bf6b04ba84d91497c272291cd0830c21d5ca98ce2c771fabf2\",\"index.html\":\"43967c1b38524ed5d744b53a2c1d6cc3e73dbd7e149ed5704c3826c3027909d3\",\"page.webmanifest\":\"909a00587727949215a61974b50bfb8f15bda9c788e30bb4cdae5af19732dc86\"}");
/** What the page itself names: enough to say that the robot is away. */
const SHELL = JSON.parse("[\"index.html\",\"icon.svg\",\"icon-192.png\",\"page.webmanifest\",\"assets/index-DQT3jTGi.js\",\"assets/parts-DgmqwHJP.js\",\"assets/index-rgPNC9JQ.css\"]");
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
