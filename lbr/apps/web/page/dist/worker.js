// Keeps the page for a robot that is off or far: the files that it was built with, each checked by its digest, and nothing
// else. What the robot says is never kept. The build fills in the names.
const BUILD = "06b57c3ecf9d3793";
/** @type {Record<string, string>} */
const FILES = JSON.parse("{\"assets/Behaviours-B9qZ2qmM.js\":\"5e6b0de9d221f360e5fcfff65b423230de0dacb075d912a7e82f1e6c1a6b439d\",\"assets/Behaviours-ju1TH5lu.css\":\"7df80eb0fe64b2ebddd196abb60e688fe2d0c3fdb01c7e65492934acb953265b\",\"assets/Below-DgJw3zzH.js\":\"b0e93a8c26b117f29ba52462192ffe405f61755052c607b34d4edbe957813ae7\",\"assets/Call-B5myZyvC.css\":\"9bd95ba7d1077c3c66775bc4757281e32365e5b943c7bc7624cd626d4792f397\",\"assets/Call-CFzNlF0b.js\":\"5c292aafe429d1634cb3000ac7cd0363df01be22e1b67e822c878b013e8b4060\",\"assets/Display-CSmLFAqf.js\":\"0cc1dac1cefa63a55dc035f982923bb69e01d51c5b69ee2a882f24da52118439\",\"assets/Display-NQ95WRFc.css\":\"7ac5d0b42865202760c3cc3fcdeb9f6aae740f24e27ee4d65c06575e4ae56193\",\"assets/Drive-BXh3BvDb.css\":\"cebbcfa50b8dd0c6a12580c3365a6917902b1b3462e54b1ccc4e554abc36d088\",\"assets/Drive-C9-SoL4S.js\":\"77bd0dd4a29189201c8f253f5637022124b395b714a441b202102870aa9232b3\",\"assets/Joints-DB6ieKRl.js\":\"60c130ed39620e1f421e4477360c89ba7067c32ce625c074fbf6ed7913b5f56a\",\"assets/Lacking-CT1guSrJ.js\":\"2ddeea4c2963bf951965cf048feecfa2cc5750e57539cd6fb25e7111b37344b2\",\"assets/Lacking-CacvYTQJ.css\":\"c7c4f4a3d3af03716a518f6da6ec94b34d1ffc67385869d3316d0f32ce4ddef3\",\"assets/Log-zWBndXwt.js\":\"333017581f081a1eb6642eb08f107a74da8f4ece92362c706901a9ebfadd5898\",\"assets/Motions-B20h2OaE.js\":\"4946992a24d7993a3ea31baa87613a72b6ea34e6091ced3a465bcabcca5ce339\",\"assets/Motions-CaFlTiXz.css\":\"3ae2ef57347e7e60dc54ae7e27f44ce213a22abdda941217da9332eb71385719\",\"assets/System-CR_Xh-7I.js\":\"003d0d9e2046565243aa1308bd2a2a41e58a63e7b120175b79426a214e16bbda\",\"assets/System-DzGb0BSC.css\":\"24e170c69cd29e16f2088d6e853fad573a6835cf7d5736dadcb7954f3f03fb00\",\"assets/access-C-8HECaz.js\":\"3d062102fb99e033ebcaeaec30d33e0118d966c86bbae5aa86c0abcfd2e2cd3b\",\"assets/connection-SUfeD7O2.js\":\"1b89ea8c521d0e6f15d2b558cc3b88a877f16ab98fb3ab05e664ca25d873b6a5\",\"assets/data-C1oBfKd0.js\":\"81cdbedd1d1931a388701eaf8e11f2090993fd558b8fac3dcfe0cb213d0f180b\",\"assets/index-BGREsrjD.js\":\"ab7d5c323960475f731405accb4b491b86bac3c31ce02bb260ad41e7a3631b25\",\"assets/index-DrfhNA8_.css\":\"2a05279a6876bf121c01175a22aee496b2429adc0521a0755d636d146c10bdb3\",\"assets/manage-C5dkba6b.js\":\"3819e6e7d4c1110f30668dfe7a4aa49e1d7c843e455f89287bbe0ddd4afbf7be\",\"assets/model-B-VaOlmR.js\":\"a55b0aa74d3e1bbcd12a2530cd2fe01c4f45d92981b82e9481f1ed54c132deb6\",\"assets/model-BjR3jKsp.css\":\"e7b501306dc22d125bfd1c47dd9ad7e8822c5ccca5776778dd408da0b97061c5\",\"assets/news-Cn7t46d-.js\":\"fe715c2a6835aac58cbf73e37d80935b4f6af07b5417ee02e86aee2b70daccc9\",\"assets/parts-CUn1Hkvc.js\":\"18106439aaa52c1c7fbeaf6b036afe07190363c430bf2127395cb23e5f40bc7a\",\"assets/stage-DWBW_tmS.js\":\"dbdf408d632fbafd0626ee1a8f3a80d3d0493da230c3c2093690419dfdc013c9\",\"assets/stream-BGwpH86Y.js\":\"63ab771df78e6bfc6fa338a36f01a0b4e2bb2f7c1293d9e34b3a4c7d29162238\",\"assets/uPlot-CnsZ1jie.css\":\"0fd9465202f6dfceac29e67c17e5ac9fb1b7ba7615c1bb08782391b791d9f1e0\",\"assets/uPlot.esm-BScb58at.js\":\"068506d72590b07d0e53e012ff1541813c52c09bded848b3f97fcd1d4b0fd3b2\",\"favicon.ico\":\"eb66fde2ce87c9f33228184353f8a8c7ff0517cd76eaf9d6a94759bbd7276be9\",\"icon-192.png\":\"df4dde7d57f1963226b36d9501a3b173c02eddc858bef226ae0176dbb4b7ee19\",\"icon-512.png\":\"6e797a05bab65afa3472b6a2bbc42b2f7a33115ab789fa2403c592655657e04d\",\"icon-maskable.png\":\"98caea4e0138a5272161323354bea3585ecac298ff8576823258aeddee01a45f\",\"icon.svg\":\"d12d71c61b9b10bf6b04ba84d91497c272291cd0830c21d5ca98ce2c771fabf2\",\"index.html\":\"2ddca1413c118f96a06e949c04acbc96924b2ec8bab6fdd711f181df85cce67c\",\"page.webmanifest\":\"909a00587727949215a61974b50bfb8f15bda9c788e30bb4cdae5af19732dc86\"}");
/** What the page itself names: enough to say that the robot is away. */
const SHELL = JSON.parse("[\"index.html\",\"icon.svg\",\"icon-192.png\",\"page.webmanifest\",\"assets/index-BGREsrjD.js\",\"assets/access-C-8HECaz.js\",\"assets/parts-CUn1Hkvc.js\",\"assets/index-DrfhNA8_.css\"]");
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
