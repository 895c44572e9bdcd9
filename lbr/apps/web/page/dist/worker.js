// Keeps the page for a robot that is off or far: the files that it was built with, each checked by its digest, and nothing
// else. What the robot says is never kept. The build fills in the names.
const BUILD = "0b2cfc487013058e";
/** @type {Record<string, string>} */
const FILES = JSON.parse("{\"assets/Behaviours-CW6UGM9H.css\":\"f8ec05f55e6ffeb2c0ecf622c8f86b9bcd1e9fc4197c1fb4ed8135c322d9d1a4\",\"assets/Behaviours-YRB7DT66.js\":\"d30079bb4bd28e306ac56a934883d7ffe73ddfd219ab70fba734b6b521432ca1\",\"assets/Below-DKNN6p04.js\":\"af21950646ddda80459ac11c8052660fb09bf7805f41c5ac4dd587e1ebaf4e1a\",\"assets/Call-B-qlq4_l.js\":\"d08efd50b78b894a85474b1dc0fa0c71fd34eae6b13bf85852f70ae9dea50398\",\"assets/Call-BH-FlvRt.css\":\"72c27a044611bd5e73568c62521730576fefce8c2a7bc35fb38ab268f89da215\",\"assets/Display-BV0Imw8L.js\":\"51efa87732bb380686e69973eceda69920f6dfda7d5ab02d178eb09e06030731\",\"assets/Display-hbDRwTTd.css\":\"c83eeecb550859a06b9cd577a58e8c226d9ef24d37e0f7fb05ec1f901b52e67e\",\"assets/Drive-C7fV0WwG.css\":\"9f36af9e8f4dd18ad7b833878ca4baf3e08aceeb3d22084309d223bb051172bc\",\"assets/Drive-GY3ZQx_i.js\":\"f007f65e251fd5797e240aa05ee98adfeba51037f94c8a3dbcf94375440f3e94\",\"assets/Joints-CyTcqowX.js\":\"4d530eb18d2593cd70a678e2a91eb57e5c1ff24d9668e9482c6f1e9fbab1c18c\",\"assets/Lacking-CPGJ4ywb.js\":\"4b04d095d505426cafd69ae90786f2f9c5d3d7ef5803b642b694e59c54875d7b\",\"assets/Lacking-CacvYTQJ.css\":\"c7c4f4a3d3af03716a518f6da6ec94b34d1ffc67385869d3316d0f32ce4ddef3\",\"assets/Log-DBVZzayb.js\":\"4093b4e27d147833c2eccd277039541449f48abef987c904ee265d9884392448\",\"assets/Motions-BtuRYnRa.js\":\"87fd21862cef47b9dc5c9a12a15d7d74080e72ad73929751e53772d21c519ee6\",\"assets/Motions-paJ-cc2G.css\":\"57d2fce9f4270827406c9d4b7c5d5cfcaa268387e079fa275368e32c9922b3f1\",\"assets/System-CAGU8Dof.css\":\"ae933e9c36299104bd16c32c77243303a9aac415f91195177bf4a3e59a11cf9e\",\"assets/System-CJdf9cv8.js\":\"1b6c7cd2f4a02f7f9b5d042d9033418e08148703780d48cef334324f9af85f6c\",\"assets/access-CDdFy0RP.js\":\"e6251fffbfcadce9a4379e494f348bde33ee768212c400f07bd8eff39437eddc\",\"assets/connection-COs4CRlx.js\":\"e791acecbf114dafdb2c3229eeddbbc9bd45e53777f4ac9f317e1804d173fd3c\",\"assets/data-BFD_ThRC.js\":\"2f29789f736c66428f77bd59e714634f23e3420671df7bdbf201d835b52c9f2e\",\"assets/index-BUkpdTLL.js\":\"c141af930b06cf1c2d4cc92bc6a8415fd98d1295adc638c7fe13886b2b853921\",\"assets/index-DWdO08Zv.css\":\"0cd8bc74e233b4a804728e823f79b07fd598f349fd123c2d8f28fb5db89f60d2\",\"assets/manage-C-Wx9OiI.js\":\"ad89ded880cc6877c58437e05b2fb76fe1af7bb6706444039e3c04758e97ca96\",\"assets/model-B6y63Mvm.js\":\"cd20a2f800cb74862f40a243b4d1b5e54a04d6b87b6e49f86190e26ed4ae7d12\",\"assets/model-CrzFuEPS.css\":\"076edbee390c7f821f72791ad0fb0db45f9350c641220c8a24582d984c8c0e80\",\"assets/news-JKEnKF0F.js\":\"7df63c878dffb4c2dbd05383128b8b5e75b57447979c24bcbc9b448515dc1e18\",\"assets/parts-BbUFyl32.js\":\"8681072a0add1f9c3168297ae70b82abac105a78d664d6681e80350ded55b3ef\",\"assets/stage-Cxnvo4cI.js\":\"5fdcb2c8a47afe58829d83bc61299316c8c85e8dd5e0c4f8ceba77e977965e13\",\"assets/stream-4Mr8XtbJ.js\":\"c2e7ff8264ec2154592fff60f4e0d16dce601be36c4c998f04f9927f1a7d8b4e\",\"assets/uPlot-CnsZ1jie.css\":\"0fd9465202f6dfceac29e67c17e5ac9fb1b7ba7615c1bb08782391b791d9f1e0\",\"assets/uPlot.esm-BScb58at.js\":\"068506d72590b07d0e53e012ff1541813c52c09bded848b3f97fcd1d4b0fd3b2\",\"favicon.ico\":\"eb66fde2ce87c9f33228184353f8a8c7ff0517cd76eaf9d6a94759bbd7276be9\",\"icon-192.png\":\"df4dde7d57f1963226b36d9501a3b173c02eddc858bef226ae0176dbb4b7ee19\",\"icon-512.png\":\"6e797a05bab65afa3472b6a2bbc42b2f7a33115ab789fa2403c592655657e04d\",\"icon-maskable.png\":\"98caea4e0138a5272161323354bea3585ecac298ff8576823258aeddee01a45f\",\"icon.svg\":\"d12d71c61b9b10bf6b04ba84d91497c272291cd0830c21d5ca98ce2c771fabf2\",\"index.html\":\"0d2ed9b4d9e18b6a0bec080c9b6ac30a70541864cdd72304923a35e4869566dd\",\"page.webmanifest\":\"909a00587727949215a61974b50bfb8f15bda9c788e30bb4cdae5af19732dc86\"}");
/** What the page itself names: enough to say that the robot is away. */
const SHELL = JSON.parse("[\"index.html\",\"icon.svg\",\"icon-192.png\",\"page.webmanifest\",\"assets/index-BUkpdTLL.js\",\"assets/access-CDdFy0RP.js\",\"assets/parts-BbUFyl32.js\",\"assets/index-DWdO08Zv.css\"]");
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
