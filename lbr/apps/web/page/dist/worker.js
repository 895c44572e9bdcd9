// Keeps the page for a robot that is off or far: the files that it was built with, each checked by its digest, and nothing
// else. What the robot says is never kept. The build fills in the names.
const BUILD = "b7f0f9bd6222012c";
/** @type {Record<string, string>} */
const FILES = JSON.parse("{\"assets/Behaviours-CW6UGM9H.css\":\"f8ec05f55e6ffeb2c0ecf622c8f86b9bcd1e9fc4197c1fb4ed8135c322d9d1a4\",\"assets/Behaviours-Cb_0hGna.js\":\"aeeff0a92aa29e52461e948ff48d0e72b33cbebc14203cf55c6c3047eb4c30b5\",\"assets/Call-BH-FlvRt.css\":\"72c27a044611bd5e73568c62521730576fefce8c2a7bc35fb38ab268f89da215\",\"assets/Call-dphyQEAm.js\":\"591a0ded5112ead138a303e651fd67c87b8ab221f506898a036ece1d351a19eb\",\"assets/Display-BNUBA58a.js\":\"0581f35a22cfcda85e8d645f500a2b5ae7c3aa1bfb1b14f599e5ceb3085a9bcc\",\"assets/Display-hbDRwTTd.css\":\"c83eeecb550859a06b9cd577a58e8c226d9ef24d37e0f7fb05ec1f901b52e67e\",\"assets/Drive-1qXcFoL3.js\":\"81846d25eceff099fbe6b38415efc26bfa7376c4c40c329d6cc53381c7677b56\",\"assets/Drive-4osGqLV4.css\":\"068027e6e3fb156d06aa1ca17041a0e63f7ca8ffd7c579b59c58e6deb0f9802e\",\"assets/Joints-AKKTboZ-.js\":\"1115c6c856876dc01d626d7f2ad6b14a821b0086894a3beb73ee47fadb840140\",\"assets/Lacking-CacvYTQJ.css\":\"c7c4f4a3d3af03716a518f6da6ec94b34d1ffc67385869d3316d0f32ce4ddef3\",\"assets/Lacking-Pdj_8Uza.js\":\"ef7a68250ee56e468c21de22102f0ea5023c1bdc3c648b50d4b552578a4bf762\",\"assets/Log-B16BC82E.js\":\"bcabe9ad1d9d148933e1d3ef97a815f76d47c9e85d5fcff5df6657f74a82e756\",\"assets/Motions-CxnOFEXi.css\":\"8469f628155c6a1a826a2877357a72e019e19b21b42a7ff3ae0a2bc7d31cb181\",\"assets/Motions-DVy45Nvf.js\":\"ddbdf1e8a5c8a77b14db330a363109b7d0d8142dbd098f7477d9b3587f0e7d31\",\"assets/System-Byz79CXU.css\":\"b09219fcd4932b983e1310e1c6efa4b5cb28b8977085ba9db51545cd4203bf3a\",\"assets/System-CYJFvXWF.js\":\"e725243df0ec249b16c2447791d5d707f44a4846884c7de33e2669fbdbdd7286\",\"assets/index-DOLq-1CY.js\":\"4924b417c437d5a47e97bb5b49cdca8269e1e484fdee44bcc8fec292ea9ed780\",\"assets/index-_KY3zcl1.css\":\"ee7fa8614f5a30836f9843d438181568cac59bc9dfa0c9f9f993620a76a79878\",\"assets/manage-CNug0Y_1.js\":\"c92a68f01af8363d32aad8f2d1807acbeb79df7a1ab4de4764898b59b2fa8ae8\",\"assets/model-DHXowZ_C.css\":\"ec960a47eec173c0a883112abe447603ac0f4e9b3603cd472118936ad0120b59\",\"assets/model-DghMsqy0.js\":\"842adfdb5cd578718fb87349f8f879f98daa97dbb6c10b44b933d95fb762f2ee\",\"assets/news-BD3VDXwo.js\":\"7f31192f3a488603c2c50b39effc1546c6dd24de2d7d46f03ff4428994790dac\",\"assets/parts-DQJc3KW3.js\":\"1c87f55fc6e2dca44b642d2462ab4090292ffc21fd72766a361ffe0c5d6ff9fc\",\"assets/saving-DbPjuOQb.js\":\"94d1a2e76767f7fdfe2e444b94c2326a340904bc4ede0b5445dbbf7236821d66\",\"assets/stage-DgFr50wC.js\":\"360a17b85159379e2365ece013afce1df2843c60847f687a256a086c9ee5cd44\",\"assets/stream-CLNErP2S.js\":\"47e8b831a60509f97172b923e7b5bb73efa73fe3787435b3d220dec3840231b3\",\"assets/uPlot-CnsZ1jie.css\":\"0fd9465202f6dfceac29e67c17e5ac9fb1b7ba7615c1bb08782391b791d9f1e0\",\"assets/uPlot.esm-BScb58at.js\":\"068506d72590b07d0e53e012ff1541813c52c09bded848b3f97fcd1d4b0fd3b2\",\"favicon.ico\":\"eb66fde2ce87c9f33228184353f8a8c7ff0517cd76eaf9d6a94759bbd7276be9\",\"icon-192.png\":\"df4dde7d57f1963226b36d9501a3b173c02eddc858bef226ae0176dbb4b7ee19\",\"icon-512.png\":\"6e797a05bab65afa3472b6a2bbc42b2f7a33115ab789fa2403c592655657e04d\",\"icon-maskable.png\":\"98caea4e0138a5272161323354bea3585ecac298ff8576823258aeddee01a45f\",\"icon.svg\":\"d12d71c61b9b10bf6b04ba84d91497c272291cd0830c21d5ca98ce2c771fabf2\",\"index.html\":\"46701cd73789960706cc800831a215f5d15ee2964e4d491953ac5b6f72eca2ce\",\"page.webmanifest\":\"909a00587727949215a61974b50bfb8f15bda9c788e30bb4cdae5af19732dc86\"}");
/** What the page itself names: enough to say that the robot is away. */
const SHELL = JSON.parse("[\"index.html\",\"icon.svg\",\"icon-192.png\",\"page.webmanifest\",\"assets/index-DOLq-1CY.js\",\"assets/parts-DQJc3KW3.js\",\"assets/index-_KY3zcl1.css\"]");
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
