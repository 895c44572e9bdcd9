// Keeps the page for a robot that is off or far: the files that it was built with, each checked by its digest, and nothing
// else. What the robot says is never kept. The build fills in the names.
const BUILD = "c019fcf8909f72eb";
/** @type {Record<string, string>} */
const FILES = JSON.parse("{\"assets/Behaviours-D8M4U-HB.js\":\"6b407d8fe669d63d6fe897251f05323a64c17180474a6ddff8a5141962bf3207\",\"assets/Behaviours-ju1TH5lu.css\":\"7df80eb0fe64b2ebddd196abb60e688fe2d0c3fdb01c7e65492934acb953265b\",\"assets/Below-CUNMik4k.js\":\"de32b3c4cde8742b0603e7f04975fe5519fc6fc3eca4b14ec293bc223d1ce0af\",\"assets/Call-B-PB1F59.js\":\"aa2da8b0f97b74aa266f6cc6bb8a53fc408dced33d49b475b61465a37282a437\",\"assets/Call-B5myZyvC.css\":\"9bd95ba7d1077c3c66775bc4757281e32365e5b943c7bc7624cd626d4792f397\",\"assets/Display-BOEBbnw5.js\":\"aa5a3e77515e1ad685359d9e19da05e1699ef789bf1414ed979735723ae9b993\",\"assets/Display-hbDRwTTd.css\":\"c83eeecb550859a06b9cd577a58e8c226d9ef24d37e0f7fb05ec1f901b52e67e\",\"assets/Drive-DA0oOCw8.css\":\"ca725096dee8c5c674a829996b919b267320060c09db2b5ba6b10b2fc80d0083\",\"assets/Drive-fDtQ_USq.js\":\"93250a8e0f99f311dc5112f62b0123e32aad43294628c17a6cdde325e182e5eb\",\"assets/Joints-B2mxMJmf.js\":\"0aa17a58cba7b9bace78107e0b5f9e3cc12432d5f9cede137162a3824be45607\",\"assets/Lacking-CacvYTQJ.css\":\"c7c4f4a3d3af03716a518f6da6ec94b34d1ffc67385869d3316d0f32ce4ddef3\",\"assets/Lacking-w65lryJa.js\":\"7e41cf9bb101afd30472607b452fe2af5954c57db86cd25bad9f9e2bfbc2e157\",\"assets/Log-DV7ydZry.js\":\"e5ca5923fdaa44d8fe854a0302b4915fd3c842bb0bb04cf46651f16755fd1ae2\",\"assets/Motions-BwMvwQ6O.js\":\"7648d46a7a6a42fb49cbdc3b7e6754c0bbe8758290722105d3fd81c03469e5e3\",\"assets/Motions-CaFlTiXz.css\":\"3ae2ef57347e7e60dc54ae7e27f44ce213a22abdda941217da9332eb71385719\",\"assets/System-CrVN4m3l.js\":\"be1ed438960d4363d052c0a673f0888f556ed6ed9d61ea4806f332f7ef0442ee\",\"assets/System-DzGb0BSC.css\":\"24e170c69cd29e16f2088d6e853fad573a6835cf7d5736dadcb7954f3f03fb00\",\"assets/access-CFDUfALU.js\":\"a42f8d4ff92015e35dd4a2f5e757bd56cfaf94c62d95e5541e31403f0dfbbd3c\",\"assets/connection-B2FztIg9.js\":\"d778ef904d808d2ab045ddf308a2e9df2eef4ca9d85aa5bdfbb969c4ec4cde1c\",\"assets/data-Dvanq7KL.js\":\"15ca0ee15a21b731f095a6571725b77e8ec12dd10efed6d9b8fc6e631e436e06\",\"assets/index-BRaI_aSa.js\":\"9400f267dc4288e25e641f295946d9dd8330f7b1089e6d743a2dca864eaaa4bf\",\"assets/index-DrfhNA8_.css\":\"2a05279a6876bf121c01175a22aee496b2429adc0521a0755d636d146c10bdb3\",\"assets/manage-ao06FXJL.js\":\"59bcc85d26fb5fa088e1e4c860d328f586396f69e74fd85a2237ba0e65cbea2d\",\"assets/model-B9lvBwfW.js\":\"08baeb45bbfb714c91ad7fdf6cca9eb1239a4c8d3dc8b11cb5e376b5531fc0f8\",\"assets/model-BjR3jKsp.css\":\"e7b501306dc22d125bfd1c47dd9ad7e8822c5ccca5776778dd408da0b97061c5\",\"assets/news-NOB8Z8aP.js\":\"94416472789a92346c4cd5b7e2342578cb022f1cef1aaf913b6dd27aa23d7ac1\",\"assets/parts-EknHTUkK.js\":\"3b121a29c73489961d2be12a6768aa91b7a0a7875942c7460c8bd56b073df83a\",\"assets/stage-CMFzaD-n.js\":\"b951397dedf7aa7eb2b3fb630d9c391a00d66a86967c095d09bd2243eeac51b1\",\"assets/stream-B9EcVrlu.js\":\"3a5a57d8a802647b625fe84e17a5ada41d05e47964f46219b33dc3ec9cd587c9\",\"assets/uPlot-CnsZ1jie.css\":\"0fd9465202f6dfceac29e67c17e5ac9fb1b7ba7615c1bb08782391b791d9f1e0\",\"assets/uPlot.esm-BScb58at.js\":\"068506d72590b07d0e53e012ff1541813c52c09bded848b3f97fcd1d4b0fd3b2\",\"favicon.ico\":\"eb66fde2ce87c9f33228184353f8a8c7ff0517cd76eaf9d6a94759bbd7276be9\",\"icon-192.png\":\"df4dde7d57f1963226b36d9501a3b173c02eddc858bef226ae0176dbb4b7ee19\",\"icon-512.png\":\"6e797a05bab65afa3472b6a2bbc42b2f7a33115ab789fa2403c592655657e04d\",\"icon-maskable.png\":\"98caea4e0138a5272161323354bea3585ecac298ff8576823258aeddee01a45f\",\"icon.svg\":\"d12d71c61b9b10bf6b04ba84d91497c272291cd0830c21d5ca98ce2c771fabf2\",\"index.html\":\"c8ea65e4aea6922fa65da814522a1f3b6129a35a6dc31c3c23a2debc31be0235\",\"page.webmanifest\":\"909a00587727949215a61974b50bfb8f15bda9c788e30bb4cdae5af19732dc86\"}");
/** What the page itself names: enough to say that the robot is away. */
const SHELL = JSON.parse("[\"index.html\",\"icon.svg\",\"icon-192.png\",\"page.webmanifest\",\"assets/index-BRaI_aSa.js\",\"assets/access-CFDUfALU.js\",\"assets/parts-EknHTUkK.js\",\"assets/index-DrfhNA8_.css\"]");
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
