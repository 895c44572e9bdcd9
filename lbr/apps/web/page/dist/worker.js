// Keeps the page for a robot that is off or far: the files that it was built with, each checked by its digest, and nothing
// else. What the robot says is never kept. The build fills in the names.
const BUILD = "d3e37806128adb1c";
/** @type {Record<string, string>} */
const FILES = JSON.parse("{\"assets/Behaviours-CW6UGM9H.css\":\"f8ec05f55e6ffeb2c0ecf622c8f86b9bcd1e9fc4197c1fb4ed8135c322d9d1a4\",\"assets/Behaviours-Coeph6rs.js\":\"45bfefe7c74fcd5cc7bb3e8d43326f551be97ac5ac9d142a7f8553b608764cbf\",\"assets/Call-BH-FlvRt.css\":\"72c27a044611bd5e73568c62521730576fefce8c2a7bc35fb38ab268f89da215\",\"assets/Call-D3EvzRDR.js\":\"d25318a61f8f9def5e795a034859c726740059e64a91a23be1a85ec706d073e9\",\"assets/Display-CwLBHJgm.js\":\"8ef58afa979910a3ba461cb2fcab7ad832485a33207c11f43fe5e78515a8052d\",\"assets/Display-hbDRwTTd.css\":\"c83eeecb550859a06b9cd577a58e8c226d9ef24d37e0f7fb05ec1f901b52e67e\",\"assets/Drive-CiuoIAbs.css\":\"17805b96ada40ebf1ed073494d6679ba715eba850c1f7641880a94b0ba449301\",\"assets/Drive-DEqO1hgh.js\":\"ef1836684ab3a0eca139ac117d0fac05fc457da450df5e2532a9ff0b9be11753\",\"assets/Joints-DSnKDjyx.js\":\"6adb7893014d24357acff8c5532a3ef9f38e2861c9af6070c75910ee5d7bf35a\",\"assets/Motions-Btv9NdHD.js\":\"582432c11935030ef51018c06332cf44839aa6de72b2e16cef8309ad4e3d951d\",\"assets/Motions-DTmtowIs.css\":\"74f4e85481e71bfcd588edda731de4d747c10ec024662e83369e4c350bc0b733\",\"assets/System-B7d-fgnK.js\":\"0f390fac3104add8744412011a96529fd460bc88a32cba5b2f20732b8d710ea4\",\"assets/System-qkyGuNp3.css\":\"75801f103109cff2b00e848d5dfed66be136b193b9664f5597a1744247f92924\",\"assets/index-CCoCEd9w.js\":\"f139c37f35e67d732969298af243d126a703bc373559775612264f8cde3f6603\",\"assets/index-IhwbWSN0.css\":\"000fba70d15216a33a9dfa2c8ccc0a1ae9e2852bf0fd9a8981327438e3ba33e5\",\"assets/manage-BLSsVUky.js\":\"826ce4674f1e06fd4faa5f5ef3d1cb58b5f9c1da0a599089237bf49ddb4d870a\",\"assets/model-BRxENw0a.js\":\"4593a411120f4f0530e439c7e9b20817839a58bc96e9cba95a20eb07b2fa4160\",\"assets/model-Bx7yEgVu.css\":\"802b384b1a54f70974f60851ef6bb609817b19f6c569ccb15816cb9f8a7b4e9f\",\"assets/parts-vyr-yIqK.js\":\"03a45c1c9138cd9fbc2e65aad2a2d5771da4bde6ded8c409def1db384a580f47\",\"assets/saving-DbPjuOQb.js\":\"94d1a2e76767f7fdfe2e444b94c2326a340904bc4ede0b5445dbbf7236821d66\",\"assets/stage-DtpiScqv.js\":\"35b0aadc66fb1a271ae70d33b3e24051332cb0a62436410323e0833d254a3e40\",\"assets/stream-CdRXj93V.js\":\"a9978d3a191b3dee2dde2333204e10f7c133801aee97ece728fd7f60568be2ff\",\"assets/uPlot-CnsZ1jie.css\":\"0fd9465202f6dfceac29e67c17e5ac9fb1b7ba7615c1bb08782391b791d9f1e0\",\"assets/uPlot.esm-BScb58at.js\":\"068506d72590b07d0e53e012ff1541813c52c09bded848b3f97fcd1d4b0fd3b2\",\"icon-192.png\":\"df4dde7d57f1963226b36d9501a3b173c02eddc858bef226ae0176dbb4b7ee19\",\"icon-512.png\":\"6e797a05bab65afa3472b6a2bbc42b2f7a33115ab789fa2403c592655657e04d\",\"icon-maskable.png\":\"98caea4e0138a5272161323354bea3585ecac298ff8576823258aeddee01a45f\",\"icon.svg\":\"d12d71c61b9b10bf6b04ba84d91497c272291cd0830c21d5ca98ce2c771fabf2\",\"index.html\":\"683890bec54bbab23b025dda3cf6e8af40cc9d972f7b4b7e2f1f137eccd4c6de\",\"page.webmanifest\":\"909a00587727949215a61974b50bfb8f15bda9c788e30bb4cdae5af19732dc86\"}");
/** What the page itself names: enough to say that the robot is away. */
const SHELL = JSON.parse("[\"index.html\",\"icon.svg\",\"icon-192.png\",\"page.webmanifest\",\"assets/index-CCoCEd9w.js\",\"assets/parts-vyr-yIqK.js\",\"assets/index-IhwbWSN0.css\"]");
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
