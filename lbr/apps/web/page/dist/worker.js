// Keeps the page for a robot that is off or far: the files that it was built with, each checked by its digest, and nothing
// else. What the robot says is never kept. The build fills in the names.
const BUILD = "74cb93cb5c7f5993";
/** @type {Record<string, string>} */
const FILES = JSON.parse("{\"assets/Behaviours-Aq0LWLp6.js\":\"a599e802095b84707155b5c763115bc77c9a6770eee01f8d6028813f0b7b1ec1\",\"assets/Behaviours-CW6UGM9H.css\":\"f8ec05f55e6ffeb2c0ecf622c8f86b9bcd1e9fc4197c1fb4ed8135c322d9d1a4\",\"assets/Below-DTqV5Jbj.js\":\"e1ac77ebfcf6f584985b91f3ec79725f2b29fc9bf4592baf216e9146b8d687c4\",\"assets/Call-BH-FlvRt.css\":\"72c27a044611bd5e73568c62521730576fefce8c2a7bc35fb38ab268f89da215\",\"assets/Call-C5mJX3tD.js\":\"e047b4afd4e20830d8117b15cd8ee27068cd0d6b27cd3a0157b67520b4ec2add\",\"assets/Display-Y7UsEQkJ.js\":\"49e7addb365ef683494525c006b5549dcf30e3a819d7f8ff70e1705ce28982c7\",\"assets/Display-hbDRwTTd.css\":\"c83eeecb550859a06b9cd577a58e8c226d9ef24d37e0f7fb05ec1f901b52e67e\",\"assets/Drive-CguKo-Or.css\":\"502d412c4055f2c0f7d9d3a0c36f04fb07c4402f07fc5410662c1d7eb0c43be9\",\"assets/Drive-DvujlCpV.js\":\"f6533848788c0ba8df798327da571175da7c37e1507718706247b9e699055042\",\"assets/Joints-kw1yRScz.js\":\"d6ab2836254eca7b1c28d76f00297836744c377ab80cfb0c720051758de4ceb9\",\"assets/Lacking-CacvYTQJ.css\":\"c7c4f4a3d3af03716a518f6da6ec94b34d1ffc67385869d3316d0f32ce4ddef3\",\"assets/Lacking-Dt7mdDG9.js\":\"6af005b2e73a3482528907290f98554ff9021ce07190fe33470a67a67081c781\",\"assets/Log-k4vS9VNQ.js\":\"69e12eefaf565a5a6e8e981bd7b86cce8d84296bca7f3db534916bfd24b0a93b\",\"assets/Motions-CJQoRpbq.css\":\"da3e78579f8d170defd81f9b2104226e0f00b6d94db24d4203e26b51d8c102ac\",\"assets/Motions-oDNm6EYs.js\":\"03e945428a8b7ade321bc5874d56565d19c34d8fdbd42d5f691387e1b78a5dc5\",\"assets/System-CAGU8Dof.css\":\"ae933e9c36299104bd16c32c77243303a9aac415f91195177bf4a3e59a11cf9e\",\"assets/System-CyJvwKuK.js\":\"ac8111ea955ce8f80c0b66e859b44d780d1d51545e76af9f5f047c03186f7d88\",\"assets/access-m3NhhPT1.js\":\"0844e8b1ba73eb17ff20ff9477833d7f66b632bc3a1ef8ea786106a9d4722f4e\",\"assets/connection-BP-EJ5aM.js\":\"6d650d4ff178361a80ee9baa175e5825c87f912a7f4af554b0c1eb005832c11d\",\"assets/index-DnLj4Brq.js\":\"4921e36467aa02809771361a78994fdd1f162ac8c282f6c7ee322b8302290048\",\"assets/index-vliHum7_.css\":\"c970a95cc69c89b7669dc68bba73449f505c57edddc1e2b0a3fb7bffd0f03381\",\"assets/manage-B2FANFYR.js\":\"dbacef1d162916e6cb04582ccec3d3a720c0e50f212a7b2080b0f4aec29b0262\",\"assets/model-BhDZKaW7.css\":\"6c5740c3b5ac779d9bac281576b4fbb48c5da54a165bce2a4712f8052b110d74\",\"assets/model-DcY4ebet.js\":\"1b7b250b7016db04cfac6a4b047845c59a2a53970435f9d90d97002433dc05d9\",\"assets/news-IiPprTei.js\":\"6cd461e508b3332d479545b8428e0564b3c5b34c21bbb043f83807a3b135c070\",\"assets/parts-9IEScrAw.js\":\"a23bb0063a2fe62fd6c6045a6e5da460be04b14eaed675f2b3b3710b6a2fe865\",\"assets/saving-DbPjuOQb.js\":\"94d1a2e76767f7fdfe2e444b94c2326a340904bc4ede0b5445dbbf7236821d66\",\"assets/stage-C-DmwY4X.js\":\"a54013fe961f8cda54dc6bf17210558975325f04fcec8a8fdce6683ee671e274\",\"assets/stream-Cgw8oyWj.js\":\"d5552a280c7b77694f7eca0501e6f8aa527f45ff8121bd3f86ba7ececf67c7be\",\"assets/uPlot-CnsZ1jie.css\":\"0fd9465202f6dfceac29e67c17e5ac9fb1b7ba7615c1bb08782391b791d9f1e0\",\"assets/uPlot.esm-BScb58at.js\":\"068506d72590b07d0e53e012ff1541813c52c09bded848b3f97fcd1d4b0fd3b2\",\"favicon.ico\":\"eb66fde2ce87c9f33228184353f8a8c7ff0517cd76eaf9d6a94759bbd7276be9\",\"icon-192.png\":\"df4dde7d57f1963226b36d9501a3b173c02eddc858bef226ae0176dbb4b7ee19\",\"icon-512.png\":\"6e797a05bab65afa3472b6a2bbc42b2f7a33115ab789fa2403c592655657e04d\",\"icon-maskable.png\":\"98caea4e0138a5272161323354bea3585ecac298ff8576823258aeddee01a45f\",\"icon.svg\":\"d12d71c61b9b10bf6b04ba84d91497c272291cd0830c21d5ca98ce2c771fabf2\",\"index.html\":\"f9b8dbd703f7c4db6cfc216d3ebb416f085bbfd935f5e18c3b269456e9430eac\",\"page.webmanifest\":\"909a00587727949215a61974b50bfb8f15bda9c788e30bb4cdae5af19732dc86\"}");
/** What the page itself names: enough to say that the robot is away. */
const SHELL = JSON.parse("[\"index.html\",\"icon.svg\",\"icon-192.png\",\"page.webmanifest\",\"assets/index-DnLj4Brq.js\",\"assets/access-m3NhhPT1.js\",\"assets/parts-9IEScrAw.js\",\"assets/index-vliHum7_.css\"]");
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
