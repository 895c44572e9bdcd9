// Keeps the page for a robot that is off or far: the files that it was built with, each checked by its digest, and nothing
// else. What the robot says is never kept. The build fills in the names.
const BUILD = "0e775b058456f27a";
/** @type {Record<string, string>} */
const FILES = JSON.parse("{\"assets/Behaviours-CZwHGZTP.js\":\"8adce7a76053d25b2926c2aaa928b3da55504194b643485f9dd724a7ed7f4300\",\"assets/Behaviours-ju1TH5lu.css\":\"7df80eb0fe64b2ebddd196abb60e688fe2d0c3fdb01c7e65492934acb953265b\",\"assets/Below-d5og8Fu1.js\":\"33fd2434fd0337099648c53f2f4ebce6c9a10258b73d0e83acce58f287e1d7a2\",\"assets/Call-B5myZyvC.css\":\"9bd95ba7d1077c3c66775bc4757281e32365e5b943c7bc7624cd626d4792f397\",\"assets/Call-_7YY3H8_.js\":\"7007fd2a8ae81a02b8572a4c470d98790c492e0ec8d0376ba8b8754ee71993de\",\"assets/Display-BiWN0I7K.js\":\"cd1c68e1e852911094b14ac6c843b62a41acd139f1c8d598f96b399d96cbfec4\",\"assets/Display-NQ95WRFc.css\":\"7ac5d0b42865202760c3cc3fcdeb9f6aae740f24e27ee4d65c06575e4ae56193\",\"assets/Drive-BJY_ussW.js\":\"951a96e12f69d54e0bffe7bb56abefe135eb681da42b87d11bd11d7693f9fde1\",\"assets/Drive-BXh3BvDb.css\":\"cebbcfa50b8dd0c6a12580c3365a6917902b1b3462e54b1ccc4e554abc36d088\",\"assets/Joints-BnQr8xHv.js\":\"c957816e9b2136bce0325a406848c76ecd7275579e89c55fefb8cfd1a4e50da0\",\"assets/Lacking-CBNNuhLg.js\":\"3339541af5841aef62154e8951b349c174ff36f0ded994e5d75b865ca634f898\",\"assets/Lacking-CacvYTQJ.css\":\"c7c4f4a3d3af03716a518f6da6ec94b34d1ffc67385869d3316d0f32ce4ddef3\",\"assets/Log-chiIWCYY.js\":\"857b31e01080671e5872a211ffde967c39bf4d4b57b8285894f7eed5b2623bde\",\"assets/Motions-BJ0TUX4n.js\":\"2ce5359ca75e2d546d47d6077354251182e591d3e333593f1720fe8f494c46f6\",\"assets/Motions-CaFlTiXz.css\":\"3ae2ef57347e7e60dc54ae7e27f44ce213a22abdda941217da9332eb71385719\",\"assets/System-D8hhvyL4.js\":\"a85ca8be8edae504fb1616a187ae662920b5882b1da4b284b422614eefba83e8\",\"assets/System-DzGb0BSC.css\":\"24e170c69cd29e16f2088d6e853fad573a6835cf7d5736dadcb7954f3f03fb00\",\"assets/access-C-8HECaz.js\":\"3d062102fb99e033ebcaeaec30d33e0118d966c86bbae5aa86c0abcfd2e2cd3b\",\"assets/connection-SUfeD7O2.js\":\"1b89ea8c521d0e6f15d2b558cc3b88a877f16ab98fb3ab05e664ca25d873b6a5\",\"assets/data-BdWcjZlx.js\":\"30230860b7039639cbe61cd54f378ffa3c25aa4cebb205be322f145ad85b8eed\",\"assets/index-DBOWwlCV.js\":\"85a9ddf845a428a14bf65f222ffaeb0c8700dbdd302f1669a30e32994f05ec61\",\"assets/index-DrfhNA8_.css\":\"2a05279a6876bf121c01175a22aee496b2429adc0521a0755d636d146c10bdb3\",\"assets/manage-BCM5yd-J.js\":\"3d83411cebd39426f01bd38936a9d1d9624579e08b549fe7113b768b203d001b\",\"assets/model-BZ7AAyFm.js\":\"f42ca5e5e504972a9b6e459fe167d4a1de4ee713ed7b5a92218777051586d66c\",\"assets/model-BjR3jKsp.css\":\"e7b501306dc22d125bfd1c47dd9ad7e8822c5ccca5776778dd408da0b97061c5\",\"assets/news-DZMyi7Tz.js\":\"73182edddea65fbede902e82164644644ae03e159da13d1847768860950cbb48\",\"assets/parts-DhItGz90.js\":\"59f4697043e1ef5d9aaba35e306c066a68d2454e474061285cc9ff794ee0beda\",\"assets/stage-DgT-rrC7.js\":\"24994724b0c808540135874d0e9ee4673d968798824a96eb43e2ab2b4c8228b3\",\"assets/stream-VC7J-xED.js\":\"e750156c73427d7b1a99f9b01b7db269f7b7b294c3ffd2c77d80cb0de31dbdac\",\"assets/uPlot-CnsZ1jie.css\":\"0fd9465202f6dfceac29e67c17e5ac9fb1b7ba7615c1bb08782391b791d9f1e0\",\"assets/uPlot.esm-BScb58at.js\":\"068506d72590b07d0e53e012ff1541813c52c09bded848b3f97fcd1d4b0fd3b2\",\"favicon.ico\":\"eb66fde2ce87c9f33228184353f8a8c7ff0517cd76eaf9d6a94759bbd7276be9\",\"icon-192.png\":\"df4dde7d57f1963226b36d9501a3b173c02eddc858bef226ae0176dbb4b7ee19\",\"icon-512.png\":\"6e797a05bab65afa3472b6a2bbc42b2f7a33115ab789fa2403c592655657e04d\",\"icon-maskable.png\":\"98caea4e0138a5272161323354bea3585ecac298ff8576823258aeddee01a45f\",\"icon.svg\":\"d12d71c61b9b10bf6b04ba84d91497c272291cd0830c21d5ca98ce2c771fabf2\",\"index.html\":\"c86639d4d6702dcc4aeb0daa8b9abda6a4f5bd28c60732c7d1af663d737528a2\",\"page.webmanifest\":\"909a00587727949215a61974b50bfb8f15bda9c788e30bb4cdae5af19732dc86\"}");
/** What the page itself names: enough to say that the robot is away. */
const SHELL = JSON.parse("[\"index.html\",\"icon.svg\",\"icon-192.png\",\"page.webmanifest\",\"assets/index-DBOWwlCV.js\",\"assets/access-C-8HECaz.js\",\"assets/parts-DhItGz90.js\",\"assets/index-DrfhNA8_.css\"]");
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
