// Keeps the page for a robot that is off or far: the files that it was built with, each checked by its digest, and nothing
// else. What the robot says is never kept. The build fills in the names.
const BUILD = "3f94470346474ecf";
/** @type {Record<string, string>} */
const FILES = JSON.parse("{\"assets/Behaviours-BmfG5Wma.js\":\"c02b116b0cdc38832f1e34d14c77665498b21eea7bb806c36e9aaf70c755a85c\",\"assets/Behaviours-CW6UGM9H.css\":\"f8ec05f55e6ffeb2c0ecf622c8f86b9bcd1e9fc4197c1fb4ed8135c322d9d1a4\",\"assets/Call-BH-FlvRt.css\":\"72c27a044611bd5e73568c62521730576fefce8c2a7bc35fb38ab268f89da215\",\"assets/Call-DVI-Xsv4.js\":\"87a17eb213de87a24c6fbc6838e3d328379c081d7fbf99372cb4c31d0d7182e5\",\"assets/Display-CE_bDxdQ.js\":\"2043e86caabe866d001ab24fafa8988c5107caa7fbd7ccd1faaaf9d69dedb43e\",\"assets/Display-hbDRwTTd.css\":\"c83eeecb550859a06b9cd577a58e8c226d9ef24d37e0f7fb05ec1f901b52e67e\",\"assets/Drive-CIzn5YtY.css\":\"33ac34cd8a6833763b364446a5c92d9c73372cbe12902189749570c614f3bd52\",\"assets/Drive-D6tgI9PP.js\":\"e7cb86ffc1ca1a96fac92a0e5e67f58d6deedfcbbc68f1cfa901bbc088c7cd63\",\"assets/Joints-VsgSgmRq.js\":\"0506e7f6a00a3bce2d8ae0d1d9fe82cb41a0b1d353ac07aa82aafda13b63fb29\",\"assets/Motions-BGku7CoI.js\":\"ccdefa063f443519b9b4a3626d9379fd72e023bf8302a5783d3f58ecc4ca830f\",\"assets/Motions-DTmtowIs.css\":\"74f4e85481e71bfcd588edda731de4d747c10ec024662e83369e4c350bc0b733\",\"assets/System-DDx4SAUs.css\":\"3ee00a8d95ac92c760a3c7567de726908c8490d3599974ee01bd3177aea6c921\",\"assets/System-DhhiUYbQ.js\":\"52137dccd6aa7c83771e9a80517b9a7b14bbdd080d89503e7d4f4e6e377eb7d0\",\"assets/index-BzAGdtnF.js\":\"76505bd33a08a110958cc6f14935e91646b3ed105f2e62428a48f9d635812b54\",\"assets/index-CqXgex_i.css\":\"8d0403160b41ab82f3daa20702698b6a1929373a93d233f1e421aa776a8bae0f\",\"assets/manage-BVw_fZxL.js\":\"3567f1f6dafd37a5e4ce17412b9743c4f9360f6a8a73314fb5a4a4acc04a81a0\",\"assets/model-Bx7yEgVu.css\":\"802b384b1a54f70974f60851ef6bb609817b19f6c569ccb15816cb9f8a7b4e9f\",\"assets/model-DFdTYeqY.js\":\"e4d2a571b642f47549441201f621c3eda3464756236727b043a9f49522bd76d6\",\"assets/parts-BQDHUAuy.js\":\"0688aa2a04df2a9a6c0d60b4bd1add810d6adf7ed7d00581be41095891221feb\",\"assets/saving-DbPjuOQb.js\":\"94d1a2e76767f7fdfe2e444b94c2326a340904bc4ede0b5445dbbf7236821d66\",\"assets/stage-Dg64ZYe9.js\":\"d11f1487986ef52ca72d46911f06071d0f4eef48082df4a2465947b0269b978f\",\"assets/stream-CTQMSPqT.js\":\"a1a41863e7009c26144110fe0c2ab7cb06f01d90ceaff78a2fbf32ee61d05dbf\",\"assets/uPlot-CnsZ1jie.css\":\"0fd9465202f6dfceac29e67c17e5ac9fb1b7ba7615c1bb08782391b791d9f1e0\",\"assets/uPlot.esm-BScb58at.js\":\"068506d72590b07d0e53e012ff1541813c52c09bded848b3f97fcd1d4b0fd3b2\",\"icon-192.png\":\"df4dde7d57f1963226b36d9501a3b173c02eddc858bef226ae0176dbb4b7ee19\",\"icon-512.png\":\"6e797a05bab65afa3472b6a2bbc42b2f7a33115ab789fa2403c592655657e04d\",\"icon-maskable.png\":\"98caea4e0138a5272161323354bea3585ecac298ff8576823258aeddee01a45f\",\"icon.svg\":\"d12d71c61b9b10bf6b04ba84d91497c272291cd0830c21d5ca98ce2c771fabf2\",\"index.html\":\"6962f5549c42a3db7db2099d250cf427d69e1937df9a4f84a5a82a858602feb3\",\"page.webmanifest\":\"909a00587727949215a61974b50bfb8f15bda9c788e30bb4cdae5af19732dc86\"}");
/** What the page itself names: enough to say that the robot is away. */
const SHELL = JSON.parse("[\"index.html\",\"icon.svg\",\"icon-192.png\",\"page.webmanifest\",\"assets/index-BzAGdtnF.js\",\"assets/parts-BQDHUAuy.js\",\"assets/index-CqXgex_i.css\"]");
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
