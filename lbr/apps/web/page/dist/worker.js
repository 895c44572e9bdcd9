// Keeps the page for a robot that is off or far: the files that it was built with, each checked by its digest, and nothing
// else. What the robot says is never kept. The build fills in the names.
const BUILD = "64dcb3b07ab7b72b";
/** @type {Record<string, string>} */
const FILES = JSON.parse("{\"assets/Behaviours-CW6UGM9H.css\":\"f8ec05f55e6ffeb2c0ecf622c8f86b9bcd1e9fc4197c1fb4ed8135c322d9d1a4\",\"assets/Behaviours-CYTRHey3.js\":\"1b6fb4d62971e168503cf0bf225f79d9828bdeaabc3752b0f31edad01dcc7823\",\"assets/Below-BvOWlugh.js\":\"a18cddc1c19ea8f888d27e9583457c8be244233a6900ea9d61717b16f81acdb2\",\"assets/Call-BH-FlvRt.css\":\"72c27a044611bd5e73568c62521730576fefce8c2a7bc35fb38ab268f89da215\",\"assets/Call-CQPDSMBc.js\":\"2faf01de3461dce332f71513306a09f6e63fc87400863f643d7bd852e6366090\",\"assets/Display-Bb37jTL-.js\":\"edac1a0218812d3ae74c583c2d51c5c8fdd314291d85a09246f7b99e0ee575ca\",\"assets/Display-hbDRwTTd.css\":\"c83eeecb550859a06b9cd577a58e8c226d9ef24d37e0f7fb05ec1f901b52e67e\",\"assets/Drive-Bd3JUZ0d.js\":\"4439dc81a8b59d064e2b3d412d7c4ff6a4cc8c9e7f35cdfbf189c27fe0cf666a\",\"assets/Drive-C7fV0WwG.css\":\"9f36af9e8f4dd18ad7b833878ca4baf3e08aceeb3d22084309d223bb051172bc\",\"assets/Joints-CeuwK-LF.js\":\"ed3e5c5515a169a0c96757001a0c761044ef2c49f27a00e3bb09653cdb0ef347\",\"assets/Lacking-CacvYTQJ.css\":\"c7c4f4a3d3af03716a518f6da6ec94b34d1ffc67385869d3316d0f32ce4ddef3\",\"assets/Lacking-DLnps50x.js\":\"ad9da1bb8901bc4f6fb59bc18cf4e8f2a962d1629404e0b76d550a4c56466512\",\"assets/Log-B9p9aUf8.js\":\"32144a33951d978c6a9e6807f994cbac0dbe5a5d14bab2d91abe8d89c27778b9\",\"assets/Motions-Q3xep6kX.js\":\"3f0dfcdf3035249e800ed96c8156e0d447a3046375310999941abe28b7e8fc8f\",\"assets/Motions-paJ-cc2G.css\":\"57d2fce9f4270827406c9d4b7c5d5cfcaa268387e079fa275368e32c9922b3f1\",\"assets/System-BmlZYhOO.js\":\"3aefd66f1e94f399f4a20045116e053a19f71e109e2a72f49df6a3075191e50a\",\"assets/System-CAGU8Dof.css\":\"ae933e9c36299104bd16c32c77243303a9aac415f91195177bf4a3e59a11cf9e\",\"assets/access-CDdFy0RP.js\":\"e6251fffbfcadce9a4379e494f348bde33ee768212c400f07bd8eff39437eddc\",\"assets/connection-COs4CRlx.js\":\"e791acecbf114dafdb2c3229eeddbbc9bd45e53777f4ac9f317e1804d173fd3c\",\"assets/data-CFXzi_DU.js\":\"2753bc17eaf73cfbf2facc4270da6a4ab6c2c9475528161e4bde5227a9085857\",\"assets/index-CPyQpEW8.js\":\"9b09af0d4ecf61889377f33ecb9cc8cda285c686c3963715bf5d08194d0e9233\",\"assets/index-DWdO08Zv.css\":\"0cd8bc74e233b4a804728e823f79b07fd598f349fd123c2d8f28fb5db89f60d2\",\"assets/manage-CQ2yOzh5.js\":\"8377f63c76474e815ffa19a058944aee1dafc30a09e6789c1a13688159503320\",\"assets/model-CrzFuEPS.css\":\"076edbee390c7f821f72791ad0fb0db45f9350c641220c8a24582d984c8c0e80\",\"assets/model-clRYJ31K.js\":\"6f2915536237a426bb733ffc341b62673cd81646fb4a1e4fcc759b9aba05f561\",\"assets/news-DTSt09MV.js\":\"92d52715131d70f9895df12e4041302526708b2d627e2b15161f9a681f26d942\",\"assets/parts-CZ7AjFAT.js\":\"e0f83e9f443328a7e7cc2d092faaa2928dde827861b59635dc3fd2fcf35402ce\",\"assets/stage-Dsof6Rwj.js\":\"802bd2f260cccb51c4eac9296fe5dbc7e871e83b83c7b775835cd3f43e1d2904\",\"assets/stream-DzZujcrb.js\":\"b15e914b07804f5a8335acaee314c19a7833451d37b858f036328fd53e97aa96\",\"assets/uPlot-CnsZ1jie.css\":\"0fd9465202f6dfceac29e67c17e5ac9fb1b7ba7615c1bb08782391b791d9f1e0\",\"assets/uPlot.esm-BScb58at.js\":\"068506d72590b07d0e53e012ff1541813c52c09bded848b3f97fcd1d4b0fd3b2\",\"favicon.ico\":\"eb66fde2ce87c9f33228184353f8a8c7ff0517cd76eaf9d6a94759bbd7276be9\",\"icon-192.png\":\"df4dde7d57f1963226b36d9501a3b173c02eddc858bef226ae0176dbb4b7ee19\",\"icon-512.png\":\"6e797a05bab65afa3472b6a2bbc42b2f7a33115ab789fa2403c592655657e04d\",\"icon-maskable.png\":\"98caea4e0138a5272161323354bea3585ecac298ff8576823258aeddee01a45f\",\"icon.svg\":\"d12d71c61b9b10bf6b04ba84d91497c272291cd0830c21d5ca98ce2c771fabf2\",\"index.html\":\"6491f2ad54daba50f8ce1f8350ac28dffd3b9b2e2c2b9f0017b1f0f61b643025\",\"page.webmanifest\":\"909a00587727949215a61974b50bfb8f15bda9c788e30bb4cdae5af19732dc86\"}");
/** What the page itself names: enough to say that the robot is away. */
const SHELL = JSON.parse("[\"index.html\",\"icon.svg\",\"icon-192.png\",\"page.webmanifest\",\"assets/index-CPyQpEW8.js\",\"assets/access-CDdFy0RP.js\",\"assets/parts-CZ7AjFAT.js\",\"assets/index-DWdO08Zv.css\"]");
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
