// Keeps the page for a robot that is off or far: the files that it was built with, each checked by its digest, and nothing
// else. What the robot says is never kept. The build fills in the names.
const BUILD = "e1ff40d37134f28d";
/** @type {Record<string, string>} */
const FILES = JSON.parse("{\"assets/Behaviours-CW6UGM9H.css\":\"f8ec05f55e6ffeb2c0ecf622c8f86b9bcd1e9fc4197c1fb4ed8135c322d9d1a4\",\"assets/Behaviours-Ck3H8vQm.js\":\"35ef0a6e9f5b1977030818c1ae07525a63ef3e401dbb861879b8f4656b50693f\",\"assets/Below-DGjA9PNZ.js\":\"65960189eaf04c952d16c4fea3fad128bd6b7dc830d422fb8402a0a387584b2f\",\"assets/Call-BH-FlvRt.css\":\"72c27a044611bd5e73568c62521730576fefce8c2a7bc35fb38ab268f89da215\",\"assets/Call-DYL4vXaF.js\":\"1ca82a4c02d1ca25b1de5f091ec810b1e5badb5568e140c952c193a4a0b5822c\",\"assets/Display-B1Fh8VkR.js\":\"722c29cc34b6a59d51f5fbbaf003612d18fc8af633a3b98c7fbe0f2506f81705\",\"assets/Display-hbDRwTTd.css\":\"c83eeecb550859a06b9cd577a58e8c226d9ef24d37e0f7fb05ec1f901b52e67e\",\"assets/Drive-CguKo-Or.css\":\"502d412c4055f2c0f7d9d3a0c36f04fb07c4402f07fc5410662c1d7eb0c43be9\",\"assets/Drive-DqaA1O9d.js\":\"469322bb945bd49f1e8d2ef90dcdd09a7d652a6878efd1509db0adc3fdaad3db\",\"assets/Joints-CEdCcZiE.js\":\"0e19c792a30c4a86254149015382734b88922fb34307d0a701c781ae5e610a4b\",\"assets/Lacking-CacvYTQJ.css\":\"c7c4f4a3d3af03716a518f6da6ec94b34d1ffc67385869d3316d0f32ce4ddef3\",\"assets/Lacking-CsosTfv6.js\":\"12077a407da1cc80b57877bf315e73158dfec095b4490c44a09b4e17f051405e\",\"assets/Log-BC9NvVaQ.js\":\"acd50401340cb6f4023a446b054663aebad59061799a0f7febe018eb947ce814\",\"assets/Motions-CJQoRpbq.css\":\"da3e78579f8d170defd81f9b2104226e0f00b6d94db24d4203e26b51d8c102ac\",\"assets/Motions-G0f6g4Pm.js\":\"9e03f7d639bd3469d5477e952dd03e86e46b02ca1bc77099502f7658fb8a3ac7\",\"assets/System-CAGU8Dof.css\":\"ae933e9c36299104bd16c32c77243303a9aac415f91195177bf4a3e59a11cf9e\",\"assets/System-CduQPt3x.js\":\"cd662c959c20f3123f894ec61462e3853417ca0da0dd8c055c351380336e9f6f\",\"assets/access-m3NhhPT1.js\":\"0844e8b1ba73eb17ff20ff9477833d7f66b632bc3a1ef8ea786106a9d4722f4e\",\"assets/connection-BP-EJ5aM.js\":\"6d650d4ff178361a80ee9baa175e5825c87f912a7f4af554b0c1eb005832c11d\",\"assets/index-D1OKvMIY.js\":\"b7d6487de6e104f2827bda888880f20224c9d2c9c00e4f7270fa876f3bc4e349\",\"assets/index-vliHum7_.css\":\"c970a95cc69c89b7669dc68bba73449f505c57edddc1e2b0a3fb7bffd0f03381\",\"assets/manage-B1XwyUnk.js\":\"08066d91ef4bddf4611dab864547f514fc5db2e45f6c1dfd4530d4c5c03e5d5c\",\"assets/model-22JzUzQX.js\":\"e8c4a7b997ab0a867eab64cbb3a3e6a34d3d7e47a91af0da1a2cb551c7bf0e63\",\"assets/model-BhDZKaW7.css\":\"6c5740c3b5ac779d9bac281576b4fbb48c5da54a165bce2a4712f8052b110d74\",\"assets/news-B_WoFarY.js\":\"e4f7758fafef5e15b62de5985cc85a44ff3dfd87046842e61ff348fa287211cf\",\"assets/parts-Baw9FDka.js\":\"4f341594558f1fbc3d2d6f8f49330e93b6b8ad3c4afd9a86535649e3bb63ff2f\",\"assets/saving-DbPjuOQb.js\":\"94d1a2e76767f7fdfe2e444b94c2326a340904bc4ede0b5445dbbf7236821d66\",\"assets/stage-A5W-VNpq.js\":\"c397cfad6d78fbb19912ff3b35b8a3e78a183f7fd1d41b9cd7716f380e8730e3\",\"assets/stream-mdFgIP1w.js\":\"db00e0ec5022cf317bde9f729ac1088f1f019c3ebcb2cab23804e23e27481719\",\"assets/uPlot-CnsZ1jie.css\":\"0fd9465202f6dfceac29e67c17e5ac9fb1b7ba7615c1bb08782391b791d9f1e0\",\"assets/uPlot.esm-BScb58at.js\":\"068506d72590b07d0e53e012ff1541813c52c09bded848b3f97fcd1d4b0fd3b2\",\"favicon.ico\":\"eb66fde2ce87c9f33228184353f8a8c7ff0517cd76eaf9d6a94759bbd7276be9\",\"icon-192.png\":\"df4dde7d57f1963226b36d9501a3b173c02eddc858bef226ae0176dbb4b7ee19\",\"icon-512.png\":\"6e797a05bab65afa3472b6a2bbc42b2f7a33115ab789fa2403c592655657e04d\",\"icon-maskable.png\":\"98caea4e0138a5272161323354bea3585ecac298ff8576823258aeddee01a45f\",\"icon.svg\":\"d12d71c61b9b10bf6b04ba84d91497c272291cd0830c21d5ca98ce2c771fabf2\",\"index.html\":\"5fc0eb09f57f0519ec6f49c7e07390fb5e1eb79d7316e2635a9c7d247e1ccc0d\",\"page.webmanifest\":\"909a00587727949215a61974b50bfb8f15bda9c788e30bb4cdae5af19732dc86\"}");
/** What the page itself names: enough to say that the robot is away. */
const SHELL = JSON.parse("[\"index.html\",\"icon.svg\",\"icon-192.png\",\"page.webmanifest\",\"assets/index-D1OKvMIY.js\",\"assets/access-m3NhhPT1.js\",\"assets/parts-Baw9FDka.js\",\"assets/index-vliHum7_.css\"]");
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
