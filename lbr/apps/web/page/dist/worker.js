// Keeps the page for a robot that is off or far: the files that it was built with, each checked by its digest, and nothing
// else. What the robot says is never kept. The build fills in the names.
const BUILD = "fd61bc0351b653ea";
/** @type {Record<string, string>} */
const FILES = JSON.parse("{\"assets/Behaviours-B1MHAZNR.js\":\"e3a002175a71da5d21d556e8c8bbb2f09cf7dcbdf4bc66824185d4c9e1e6b689\",\"assets/Behaviours-CW6UGM9H.css\":\"f8ec05f55e6ffeb2c0ecf622c8f86b9bcd1e9fc4197c1fb4ed8135c322d9d1a4\",\"assets/Below-B2bpFstc.js\":\"c28556ac8a7063523ddc506a56773037c79cc8b6266fb40ac4475e2ee7bfc506\",\"assets/Call-B-7Mo-ml.js\":\"95353e4a88233233d33f4bc82056bbda2be7ca3ecd58d8d18ac201c93d81779a\",\"assets/Call-BH-FlvRt.css\":\"72c27a044611bd5e73568c62521730576fefce8c2a7bc35fb38ab268f89da215\",\"assets/Display-DKreBY1d.js\":\"432e5e21bb47f26c28a796ad01b31d170f4a373508a92c5de4572006160eeed5\",\"assets/Display-hbDRwTTd.css\":\"c83eeecb550859a06b9cd577a58e8c226d9ef24d37e0f7fb05ec1f901b52e67e\",\"assets/Drive-CguKo-Or.css\":\"502d412c4055f2c0f7d9d3a0c36f04fb07c4402f07fc5410662c1d7eb0c43be9\",\"assets/Drive-Yh5Yna0Q.js\":\"f4f5e6dd82e1102189de68eb4c9dc8b334f48728a46efafa8e4b013f47de7398\",\"assets/Joints-CRd00uGr.js\":\"5f30cb126a1bceed7b7748d493acff74b4dfe4a483f8f7e83f0f3331a55ab32c\",\"assets/Lacking-CacvYTQJ.css\":\"c7c4f4a3d3af03716a518f6da6ec94b34d1ffc67385869d3316d0f32ce4ddef3\",\"assets/Lacking-Q3IfLf5w.js\":\"88438270c3fa2b180002c8b23d832d84ab0640eff9e4fceee051a8b0fd74d577\",\"assets/Log-BG26gDZY.js\":\"ea2a67822a065cf33775f51192d6653a3b99d584e93f565d2c96b1f915fd568c\",\"assets/Motions-CJQoRpbq.css\":\"da3e78579f8d170defd81f9b2104226e0f00b6d94db24d4203e26b51d8c102ac\",\"assets/Motions-Cnj-zOGG.js\":\"62d3539e11116da6be7d9cfd76eaf765651fc2b4cef3338eeb7fc1435d5f3e9f\",\"assets/System-BApJA2GL.js\":\"938e71ae96959a7fb4bbe1c759a3bc788092b623671c6bce263ef1d490790643\",\"assets/System-CAGU8Dof.css\":\"ae933e9c36299104bd16c32c77243303a9aac415f91195177bf4a3e59a11cf9e\",\"assets/access-DCriIW49.js\":\"a76c5322af82d82075adbdbf3d0e2b16e13aa904b184e03613c9888fbce9647a\",\"assets/connection-TUqB3Ylr.js\":\"326948c16576bddf9cf65894ac9e2f1dbfd2abaf65eb43db28254c6911cfb6ea\",\"assets/data-BY0GZA9W.js\":\"17fc0d4d5e1a67c71a6e01f562bb2574fafdc7c32c2884016126db97f905c34c\",\"assets/index-BwB2-Wha.js\":\"b8383f6749dfb63a94745fae6eded19d4c025f478eee09f7a274707600812305\",\"assets/index-DWdO08Zv.css\":\"0cd8bc74e233b4a804728e823f79b07fd598f349fd123c2d8f28fb5db89f60d2\",\"assets/manage-Cd8t2rg-.js\":\"f054a9d1d5a9cc786e2c23c5488b51d0f7eb84cec9c84da6323a3d0742d06136\",\"assets/model-BhDZKaW7.css\":\"6c5740c3b5ac779d9bac281576b4fbb48c5da54a165bce2a4712f8052b110d74\",\"assets/model-QqBgNp24.js\":\"e29585674f2c53ef0e06636b6607fec0c79426ba2958c2aaa6b0e6d5573424c6\",\"assets/news-DqrKAVP8.js\":\"3c6452f3ae899587e6deed01e3d9e3ab6f047e2c27cc71ef6f3483ee64e2c6f4\",\"assets/parts-B1s68abn.js\":\"c915cf2fc341feafd93782db84a6fdbcd4116bc9bcad22212f8ed066c73fa740\",\"assets/saving-DbPjuOQb.js\":\"94d1a2e76767f7fdfe2e444b94c2326a340904bc4ede0b5445dbbf7236821d66\",\"assets/stage-C9yHNVLB.js\":\"409b6813c4ab1f6c62af8514cf910cdf55c8ab293e139818805bc2fa97421fc1\",\"assets/stream-ApAkBz2X.js\":\"749c932eb5cbdaa33f3d8a90f24d08724be9fe9b6d5370178650a64af0386b56\",\"assets/uPlot-CnsZ1jie.css\":\"0fd9465202f6dfceac29e67c17e5ac9fb1b7ba7615c1bb08782391b791d9f1e0\",\"assets/uPlot.esm-BScb58at.js\":\"068506d72590b07d0e53e012ff1541813c52c09bded848b3f97fcd1d4b0fd3b2\",\"favicon.ico\":\"eb66fde2ce87c9f33228184353f8a8c7ff0517cd76eaf9d6a94759bbd7276be9\",\"icon-192.png\":\"df4dde7d57f1963226b36d9501a3b173c02eddc858bef226ae0176dbb4b7ee19\",\"icon-512.png\":\"6e797a05bab65afa3472b6a2bbc42b2f7a33115ab789fa2403c592655657e04d\",\"icon-maskable.png\":\"98caea4e0138a5272161323354bea3585ecac298ff8576823258aeddee01a45f\",\"icon.svg\":\"d12d71c61b9b10bf6b04ba84d91497c272291cd0830c21d5ca98ce2c771fabf2\",\"index.html\":\"043998b019ce9faaefec5681eee77cd44b222752896f091a3647188992a31d56\",\"page.webmanifest\":\"909a00587727949215a61974b50bfb8f15bda9c788e30bb4cdae5af19732dc86\"}");
/** What the page itself names: enough to say that the robot is away. */
const SHELL = JSON.parse("[\"index.html\",\"icon.svg\",\"icon-192.png\",\"page.webmanifest\",\"assets/index-BwB2-Wha.js\",\"assets/access-DCriIW49.js\",\"assets/parts-B1s68abn.js\",\"assets/index-DWdO08Zv.css\"]");
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
