// Keeps the page for a robot that is off or far: the files that it was built with, each checked by its digest, and nothing
// else. What the robot says is never kept. The build fills in the names.
const BUILD = "29968e700e200aa1";
/** @type {Record<string, string>} */
const FILES = JSON.parse("{\"assets/Behaviours-CW6UGM9H.css\":\"f8ec05f55e6ffeb2c0ecf622c8f86b9bcd1e9fc4197c1fb4ed8135c322d9d1a4\",\"assets/Behaviours-dxnkMWZE.js\":\"675444fb545d3e2d07299147f305078c5722ebf2fcf10c40964fda93abce4488\",\"assets/Below-p_wEiIFN.js\":\"0f2ba4a4e5bfe98dac1f143dd6358cb8a1e1d7f7f173ff50ba30aa059d761f5f\",\"assets/Call-BH-FlvRt.css\":\"72c27a044611bd5e73568c62521730576fefce8c2a7bc35fb38ab268f89da215\",\"assets/Call-DAlVC9Li.js\":\"0b8a029cf8ffba0ea414938fe654db9125393946935e6b9d331fcd38f9e10a20\",\"assets/Display-ChlC0jIJ.js\":\"e03c55d2b5d18d65747b80e7d1bf92635a9f330d0ac13fb8c89bfff7c5865681\",\"assets/Display-hbDRwTTd.css\":\"c83eeecb550859a06b9cd577a58e8c226d9ef24d37e0f7fb05ec1f901b52e67e\",\"assets/Drive-BBD5PbDu.js\":\"9856a25e3cfb7935358ea543f265562c9d2b9aa578f3194a5a12376f05483cde\",\"assets/Drive-CguKo-Or.css\":\"502d412c4055f2c0f7d9d3a0c36f04fb07c4402f07fc5410662c1d7eb0c43be9\",\"assets/Joints-DSR9cjfG.js\":\"380686cc8c89623b4787e173e0c3f00659ff26327d46ac70796593e0ad401bc5\",\"assets/Lacking-CacvYTQJ.css\":\"c7c4f4a3d3af03716a518f6da6ec94b34d1ffc67385869d3316d0f32ce4ddef3\",\"assets/Lacking-CsFbcmo-.js\":\"8d8ce9d1a3255ddae57ef664366a8b726782fc34e03684a3e62c0f6ae8e97fba\",\"assets/Log-DVt8_Iza.js\":\"b1003ff23206e3b51ea97771dd92e835d2c6c07f50cc8e6573da213e13af1cc1\",\"assets/Motions-CJQoRpbq.css\":\"da3e78579f8d170defd81f9b2104226e0f00b6d94db24d4203e26b51d8c102ac\",\"assets/Motions-PEE3QMei.js\":\"ee0896538030d058fd3b517231236877b211f166c303e18edbba0fcc9ba137dd\",\"assets/System-CAGU8Dof.css\":\"ae933e9c36299104bd16c32c77243303a9aac415f91195177bf4a3e59a11cf9e\",\"assets/System-DwDiW2pP.js\":\"9aa078bedffaf78c05d6aaccc9a2f414fd96ee4a45dae9c3cf4f0ffdc1571ff7\",\"assets/access-m3NhhPT1.js\":\"0844e8b1ba73eb17ff20ff9477833d7f66b632bc3a1ef8ea786106a9d4722f4e\",\"assets/connection-BP-EJ5aM.js\":\"6d650d4ff178361a80ee9baa175e5825c87f912a7f4af554b0c1eb005832c11d\",\"assets/index-DF_75n36.js\":\"cc836226e878736978f8e6bf8e2b8e3a9bd3e0c46be475bcdcffc21535ecdee5\",\"assets/index-vliHum7_.css\":\"c970a95cc69c89b7669dc68bba73449f505c57edddc1e2b0a3fb7bffd0f03381\",\"assets/manage-DORx1NYT.js\":\"71838e5c721402bc9cd83663183feeaa928bf4eb4f04582052569cd1f1095281\",\"assets/model-BhDZKaW7.css\":\"6c5740c3b5ac779d9bac281576b4fbb48c5da54a165bce2a4712f8052b110d74\",\"assets/model-C_1nbzRf.js\":\"87ad859d87c97573201034fe7fc90e4bc324c0e1718d60bcc1454adbea4c822b\",\"assets/news-ChoYEt_x.js\":\"83732d4e60f17e490ce41f4b0e0a580126650af2ff2c460fcb2d5bb430479f94\",\"assets/parts-BmIG3eay.js\":\"937134c8a26de479639deadf828a9d4d700331e37a9e0fa34262a14451d168b2\",\"assets/saving-DbPjuOQb.js\":\"94d1a2e76767f7fdfe2e444b94c2326a340904bc4ede0b5445dbbf7236821d66\",\"assets/stage-EhvqKXtl.js\":\"f5b2714a1035e2466daf1b32ff76c55a18ecfbe9d91f9077e35687dded1e6c75\",\"assets/stream-DfibxGJ1.js\":\"35f4d8e7530d5ca3aa20d4e0a9181ee05df63034f4da2feb0154800a8dd201cf\",\"assets/uPlot-CnsZ1jie.css\":\"0fd9465202f6dfceac29e67c17e5ac9fb1b7ba7615c1bb08782391b791d9f1e0\",\"assets/uPlot.esm-BScb58at.js\":\"068506d72590b07d0e53e012ff1541813c52c09bded848b3f97fcd1d4b0fd3b2\",\"favicon.ico\":\"eb66fde2ce87c9f33228184353f8a8c7ff0517cd76eaf9d6a94759bbd7276be9\",\"icon-192.png\":\"df4dde7d57f1963226b36d9501a3b173c02eddc858bef226ae0176dbb4b7ee19\",\"icon-512.png\":\"6e797a05bab65afa3472b6a2bbc42b2f7a33115ab789fa2403c592655657e04d\",\"icon-maskable.png\":\"98caea4e0138a5272161323354bea3585ecac298ff8576823258aeddee01a45f\",\"icon.svg\":\"d12d71c61b9b10bf6b04ba84d91497c272291cd0830c21d5ca98ce2c771fabf2\",\"index.html\":\"11d6c45b3b0f7c27dc81d01ff2fcfb5824c0a19e8b7e586f1cba0c8bf9a27dd6\",\"page.webmanifest\":\"909a00587727949215a61974b50bfb8f15bda9c788e30bb4cdae5af19732dc86\"}");
/** What the page itself names: enough to say that the robot is away. */
const SHELL = JSON.parse("[\"index.html\",\"icon.svg\",\"icon-192.png\",\"page.webmanifest\",\"assets/index-DF_75n36.js\",\"assets/access-m3NhhPT1.js\",\"assets/parts-BmIG3eay.js\",\"assets/index-vliHum7_.css\"]");
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
