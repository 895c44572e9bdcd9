// Keeps the page for a robot that is off or far: the files that it was built with, each checked by its digest, and nothing
// else. What the robot says is never kept. The build fills in the names.
const BUILD = "5642be0da7bd0d04";
/** @type {Record<string, string>} */
const FILES = JSON.parse("{\"assets/Behaviours-CNRWNvrw.js\":\"8e788e8c2a93e7fb5346ab6d3516ccfb14e23c42b7b22a93d3f41d138335b4a8\",\"assets/Behaviours-CW6UGM9H.css\":\"f8ec05f55e6ffeb2c0ecf622c8f86b9bcd1e9fc4197c1fb4ed8135c322d9d1a4\",\"assets/Below-DHpUTlKu.js\":\"ca2a9f5003d3544cf5703ad626d30e42ad036788eb14ff61c6a168cac3800429\",\"assets/Call-7m59xqMj.js\":\"183a90578c2e5df6a1ca8c33ab5b5a7c8642c6790381bf83e9d1a8b5ecd04ae1\",\"assets/Call-BH-FlvRt.css\":\"72c27a044611bd5e73568c62521730576fefce8c2a7bc35fb38ab268f89da215\",\"assets/Display-CTBMlmED.js\":\"42cdb6a7e503d0f149b77d882358344bdbabd9737770565eaa590d6bd2d2df7a\",\"assets/Display-hbDRwTTd.css\":\"c83eeecb550859a06b9cd577a58e8c226d9ef24d37e0f7fb05ec1f901b52e67e\",\"assets/Drive-B-UVZIDo.js\":\"0e700c3f477ab0da7cac44f19a0f8cf10ee94335c88d7b8d9dfdc2159d9d0a32\",\"assets/Drive-CguKo-Or.css\":\"502d412c4055f2c0f7d9d3a0c36f04fb07c4402f07fc5410662c1d7eb0c43be9\",\"assets/Joints-C_PsycxI.js\":\"f3388fd171471e5a4a70ef1a38c2be0316edcc84444d86bef30226c664efa654\",\"assets/Lacking-BJloDWQ7.js\":\"5f91e748fbe9a8d5e7e5e0d283e2d2f05343595a5344472fded4a5ca676381a7\",\"assets/Lacking-CacvYTQJ.css\":\"c7c4f4a3d3af03716a518f6da6ec94b34d1ffc67385869d3316d0f32ce4ddef3\",\"assets/Log-CKNXS_Jf.js\":\"d7efe710ce82fdcf0a799331b35daeefdd30c94c5f7d884c6d0abedafa54abcf\",\"assets/Motions-CJQoRpbq.css\":\"da3e78579f8d170defd81f9b2104226e0f00b6d94db24d4203e26b51d8c102ac\",\"assets/Motions-ZiGAAqEi.js\":\"33e962957198899fd967397aa7804400580dd881de5c1e1d394a288f770ce5d6\",\"assets/System-Boa2CYuq.js\":\"8b2dd04c877868cb52fa9e807babb450de6af9ad77c9b7f57a1066ca7dbb1ef8\",\"assets/System-CAGU8Dof.css\":\"ae933e9c36299104bd16c32c77243303a9aac415f91195177bf4a3e59a11cf9e\",\"assets/access-DWsm892u.js\":\"bf89a67a2744550c85a112eee9ba4e32c9bfca720239428c252abb53d0d56b1b\",\"assets/connection-zZfaeIsH.js\":\"0c66660f3e3d8596fb5674055410e72b23e2ee50da0c7bc17ddf8c2e4bc9dc98\",\"assets/data-q2L7tYm8.js\":\"4ba2dd3d65331224054634d92532cf6f3659c3049dc99bf5b08d5db94cf6582e\",\"assets/index-D9eO4zoq.js\":\"353ed25268b579f915254f7e329a3fef47f953b7a0400ba7cd621e8f4744ec22\",\"assets/index-DWdO08Zv.css\":\"0cd8bc74e233b4a804728e823f79b07fd598f349fd123c2d8f28fb5db89f60d2\",\"assets/manage-D__pTWRb.js\":\"8939d838708b880844a2d6ae16592b3410223a0e35af01440693df35d781d694\",\"assets/model-BhDZKaW7.css\":\"6c5740c3b5ac779d9bac281576b4fbb48c5da54a165bce2a4712f8052b110d74\",\"assets/model-CwL8-pym.js\":\"1cb60aceeab1ac47c2d9b41671ed8c08a8679fb2db3da84607d64dcade557073\",\"assets/news-CbtAovrf.js\":\"81f14b77695e2b6df6ed45987ab363cf5dc6d09bb4b0d6421e5a525f037739a2\",\"assets/parts-BE-Y2Z2B.js\":\"446ccf0149e05315396d8c838e647aca84f6eb9679a60f2f2a953e37ddb34124\",\"assets/stage-C0qgdotB.js\":\"b2ac5f48da02e8a3d6276b59b2e01db5c2c0172147e0e7b8239e02968bde5eb4\",\"assets/stream-XRrcwsx1.js\":\"81de9fcf9c29ad3af973c43bd717980693bd693539b910d29708edd9c3dc4762\",\"assets/uPlot-CnsZ1jie.css\":\"0fd9465202f6dfceac29e67c17e5ac9fb1b7ba7615c1bb08782391b791d9f1e0\",\"assets/uPlot.esm-BScb58at.js\":\"068506d72590b07d0e53e012ff1541813c52c09bded848b3f97fcd1d4b0fd3b2\",\"favicon.ico\":\"eb66fde2ce87c9f33228184353f8a8c7ff0517cd76eaf9d6a94759bbd7276be9\",\"icon-192.png\":\"df4dde7d57f1963226b36d9501a3b173c02eddc858bef226ae0176dbb4b7ee19\",\"icon-512.png\":\"6e797a05bab65afa3472b6a2bbc42b2f7a33115ab789fa2403c592655657e04d\",\"icon-maskable.png\":\"98caea4e0138a5272161323354bea3585ecac298ff8576823258aeddee01a45f\",\"icon.svg\":\"d12d71c61b9b10bf6b04ba84d91497c272291cd0830c21d5ca98ce2c771fabf2\",\"index.html\":\"e204f08d4caaa9b9b9424f913a9530ad1fa171dcb6ac926c36ac8013c44a22fc\",\"page.webmanifest\":\"909a00587727949215a61974b50bfb8f15bda9c788e30bb4cdae5af19732dc86\"}");
/** What the page itself names: enough to say that the robot is away. */
const SHELL = JSON.parse("[\"index.html\",\"icon.svg\",\"icon-192.png\",\"page.webmanifest\",\"assets/index-D9eO4zoq.js\",\"assets/access-DWsm892u.js\",\"assets/parts-BE-Y2Z2B.js\",\"assets/index-DWdO08Zv.css\"]");
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
