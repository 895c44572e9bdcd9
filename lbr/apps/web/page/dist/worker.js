// Keeps the page for a robot that is off or far: the files that it was built with, each checked by its digest, and nothing
// else. What the robot says is never kept. The build fills in the names.
const BUILD = "6e6c236d0689d9e7";
/** @type {Record<string, string>} */
const FILES = JSON.parse("{\"assets/Behaviours-CW6UGM9H.css\":\"f8ec05f55e6ffeb2c0ecf622c8f86b9bcd1e9fc4197c1fb4ed8135c322d9d1a4\",\"assets/Behaviours-CimNes8X.js\":\"f8cd0a5bba618881c48101cf7f9837ecc569fa1d2e782b607c97f485272ddd67\",\"assets/Below-Bd0acZXA.js\":\"e8a9446d452bdb404fbc830b4175337cc29507c42dcd531cf6976fea8750bbe5\",\"assets/Call-5ABYYN0B.js\":\"e0c108fa5ffab858f65443b2051bc90f9c1e85df4aafc51dc441b076be91fedd\",\"assets/Call-BH-FlvRt.css\":\"72c27a044611bd5e73568c62521730576fefce8c2a7bc35fb38ab268f89da215\",\"assets/Display-DLhlXHKW.js\":\"efcd2ec7f43d093cdd1e9240ab002594f1226887df868ff5fdc532f6e39437c9\",\"assets/Display-hbDRwTTd.css\":\"c83eeecb550859a06b9cd577a58e8c226d9ef24d37e0f7fb05ec1f901b52e67e\",\"assets/Drive-BOYiXL-K.js\":\"0e6038b398daab6b0f5fdceee922211df1274786a83a5691ac1732d9439092ef\",\"assets/Drive-CguKo-Or.css\":\"502d412c4055f2c0f7d9d3a0c36f04fb07c4402f07fc5410662c1d7eb0c43be9\",\"assets/Joints-BSP_1qfm.js\":\"c1e6545cecf2e7d297fef225a7b8abf869b35987d20e8dda27225c21f18f7b21\",\"assets/Lacking-CUVfS2wD.js\":\"cb3732e0377df35c117068960486a31e49f5e04709744e3813be09265b3d2da0\",\"assets/Lacking-CacvYTQJ.css\":\"c7c4f4a3d3af03716a518f6da6ec94b34d1ffc67385869d3316d0f32ce4ddef3\",\"assets/Log-ptswcovz.js\":\"141d6cc81a142d6d737aa4a4f41c4e7d5dbc5a29b883c1f5d3b5679388e418b1\",\"assets/Motions-CJQoRpbq.css\":\"da3e78579f8d170defd81f9b2104226e0f00b6d94db24d4203e26b51d8c102ac\",\"assets/Motions-cPSVqJen.js\":\"ed8b59dfd3b9c2acd5ad503bdf5b9bb3b9b09a715c9c49dbe822538a5e1cfefd\",\"assets/System-CAGU8Dof.css\":\"ae933e9c36299104bd16c32c77243303a9aac415f91195177bf4a3e59a11cf9e\",\"assets/System-Dju7xgJi.js\":\"c6105917acebf5db12da82890ccc100260fe0e628198b760a30ceea6c123dc26\",\"assets/access-BktGbI93.js\":\"b4bc55714036ace8759059a131cbb467d8d7a300c63f5fd9e9e99f017c1afa72\",\"assets/connection-CUlfVPxK.js\":\"288e3aad35432c524301cfaf2bea7ad4c65ad0c137be4ecb8b2a676ca4c391e0\",\"assets/index-DAYZj2Rr.js\":\"3dad185a37b1e17bb8c3a5f85df0ba8c77cff1a8365afcf4b9492487330414bd\",\"assets/index-vliHum7_.css\":\"c970a95cc69c89b7669dc68bba73449f505c57edddc1e2b0a3fb7bffd0f03381\",\"assets/manage-CiadHrZ_.js\":\"3db26b97d7f8000274b0574fef146021710d81b0c760341b05d29e3dce6ca4a7\",\"assets/model-BSxOa2Og.js\":\"181483a9a8215e993b7a12aaf35b6000e9e63e9b6d85f1b5001b54805164a84f\",\"assets/model-BhDZKaW7.css\":\"6c5740c3b5ac779d9bac281576b4fbb48c5da54a165bce2a4712f8052b110d74\",\"assets/news-CiADYNON.js\":\"0bc07601b81376b03a649d73726dbb1acd0daf7718daaf5def9789cf1eccd8a8\",\"assets/parts-CWyxq79l.js\":\"8981f33d83bf3ac093e80bf5b19b57afa535484a78927650425bc96f6859dfb5\",\"assets/saving-DbPjuOQb.js\":\"94d1a2e76767f7fdfe2e444b94c2326a340904bc4ede0b5445dbbf7236821d66\",\"assets/stage-a9465Czn.js\":\"6a2bab8d54c6e2ff16b0bf8942dc8c80c69702837a47f05e8918bc23cc1c5174\",\"assets/stream-CmlP88mS.js\":\"03ea15b26e07f51639b96c88a7b8a0ff6dba61381a12eeb738836607b7c2d435\",\"assets/uPlot-CnsZ1jie.css\":\"0fd9465202f6dfceac29e67c17e5ac9fb1b7ba7615c1bb08782391b791d9f1e0\",\"assets/uPlot.esm-BScb58at.js\":\"068506d72590b07d0e53e012ff1541813c52c09bded848b3f97fcd1d4b0fd3b2\",\"favicon.ico\":\"eb66fde2ce87c9f33228184353f8a8c7ff0517cd76eaf9d6a94759bbd7276be9\",\"icon-192.png\":\"df4dde7d57f1963226b36d9501a3b173c02eddc858bef226ae0176dbb4b7ee19\",\"icon-512.png\":\"6e797a05bab65afa3472b6a2bbc42b2f7a33115ab789fa2403c592655657e04d\",\"icon-maskable.png\":\"98caea4e0138a5272161323354bea3585ecac298ff8576823258aeddee01a45f\",\"icon.svg\":\"d12d71c61b9b10bf6b04ba84d91497c272291cd0830c21d5ca98ce2c771fabf2\",\"index.html\":\"854c233377ec8d934128ce0625ec674a9b9efa0282718f165d85ce476f54a946\",\"page.webmanifest\":\"909a00587727949215a61974b50bfb8f15bda9c788e30bb4cdae5af19732dc86\"}");
/** What the page itself names: enough to say that the robot is away. */
const SHELL = JSON.parse("[\"index.html\",\"icon.svg\",\"icon-192.png\",\"page.webmanifest\",\"assets/index-DAYZj2Rr.js\",\"assets/access-BktGbI93.js\",\"assets/parts-CWyxq79l.js\",\"assets/index-vliHum7_.css\"]");
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
