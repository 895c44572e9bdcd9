// Keeps the page for a robot that is off or far: the files that it was built with, each checked by its digest, and nothing
// else. What the robot says is never kept. The build fills in the names.
const BUILD = "b4369ee0ab480070";
/** @type {Record<string, string>} */
const FILES = JSON.parse("{\"assets/Behaviours-C1W_FhI_.js\":\"97e043068053a3f42455d98bcd510bf38e862fba434d8ebe100fc4e1bc4a993e\",\"assets/Behaviours-ju1TH5lu.css\":\"7df80eb0fe64b2ebddd196abb60e688fe2d0c3fdb01c7e65492934acb953265b\",\"assets/Below-DjYRFFS7.js\":\"4e5feb8d81004be47007f8d734108a625679c96689c0cd6c03bf19dd92a14c51\",\"assets/Call-B5myZyvC.css\":\"9bd95ba7d1077c3c66775bc4757281e32365e5b943c7bc7624cd626d4792f397\",\"assets/Call-CGcAzxTb.js\":\"f274674de7ccf0d78d996e13c65085d188adb6de57c5e551912f7c13c95e3d67\",\"assets/Display-Dc5powGs.js\":\"74339c54007635c14e4c36f33d4ddfa27b6aad5e9c9e3d99e7bc9bfed0744fb6\",\"assets/Display-NQ95WRFc.css\":\"7ac5d0b42865202760c3cc3fcdeb9f6aae740f24e27ee4d65c06575e4ae56193\",\"assets/Drive-D45oXpUJ.js\":\"704b691f88b2ab3e916ca6af9783240a2700934062d659d724cdb1af4d1cca14\",\"assets/Drive-DA0oOCw8.css\":\"ca725096dee8c5c674a829996b919b267320060c09db2b5ba6b10b2fc80d0083\",\"assets/Joints-B3KKytUh.js\":\"a0ca822bd6a326a1e937778b5a74385918823d5c662d328638094a51d1670597\",\"assets/Lacking-BDGdmYqa.js\":\"18dc9de457a56f31603f74d9266c84db9162b7250e803441e71f604b99b84acf\",\"assets/Lacking-CacvYTQJ.css\":\"c7c4f4a3d3af03716a518f6da6ec94b34d1ffc67385869d3316d0f32ce4ddef3\",\"assets/Log-uYIqFaMd.js\":\"3f89e3113efa8ada243155533f401fea564c2f6a3803993b4b51de189dc076a8\",\"assets/Motions-CaFlTiXz.css\":\"3ae2ef57347e7e60dc54ae7e27f44ce213a22abdda941217da9332eb71385719\",\"assets/Motions-Dn9KSdib.js\":\"648a5572400f875a3f2481ed5f516261993b0def20dad504c468fd626e0d7e33\",\"assets/System-DzGb0BSC.css\":\"24e170c69cd29e16f2088d6e853fad573a6835cf7d5736dadcb7954f3f03fb00\",\"assets/System-UwGrjZ7K.js\":\"855697ac21de7ce1baa3d9f30c823172d707ddedb8cd19ef3a856188025e2a06\",\"assets/access-BhzJ2x1u.js\":\"3d357cc3580107debc3795216cf8c95f7d1e061104c0e4c687d29cb87443ec88\",\"assets/connection-BlULrnFL.js\":\"c17294d64f0642ffaa2d6cf2164c23cc8e9683f9c274a16c026b22633ada09a0\",\"assets/data-C9vwZN0r.js\":\"1c30b8312a570cc38b3eb697c95249034e4cfb8b70f001bacc14658bc0884f37\",\"assets/index-DrfhNA8_.css\":\"2a05279a6876bf121c01175a22aee496b2429adc0521a0755d636d146c10bdb3\",\"assets/index-DupXE_TZ.js\":\"b3edb21e4ff10d42afb646256eeace726e9ae323619891a40a0946e768034ae9\",\"assets/manage-BVpujmuK.js\":\"0f90637f359d777e956007ecad2bfa9bff9cf6126517f61de0f19206be010263\",\"assets/model-BhuID0d3.js\":\"4ec620086be80172098f9b857235579525b3800f70f3dd97521b3aa2e1b3b245\",\"assets/model-BjR3jKsp.css\":\"e7b501306dc22d125bfd1c47dd9ad7e8822c5ccca5776778dd408da0b97061c5\",\"assets/news-jQL0X2uA.js\":\"3013615aa17cf66e72c0c2b2ec5ca16f09b334ed17e3e62d4348d49ae45a5648\",\"assets/stage-DXsoZw6T.js\":\"f5d46e56ce362414abc071dcc8c67dc8c0175bdfc385670867fae0ec5faf42f8\",\"assets/stream-BPZGfJaZ.js\":\"e7659b3e1abd8dc384936961302aec231a562c56dd72028f5a5d8734736a1a1f\",\"assets/uPlot-CnsZ1jie.css\":\"0fd9465202f6dfceac29e67c17e5ac9fb1b7ba7615c1bb08782391b791d9f1e0\",\"assets/uPlot.esm-BScb58at.js\":\"068506d72590b07d0e53e012ff1541813c52c09bded848b3f97fcd1d4b0fd3b2\",\"favicon.ico\":\"eb66fde2ce87c9f33228184353f8a8c7ff0517cd76eaf9d6a94759bbd7276be9\",\"icon-192.png\":\"df4dde7d57f1963226b36d9501a3b173c02eddc858bef226ae0176dbb4b7ee19\",\"icon-512.png\":\"6e797a05bab65afa3472b6a2bbc42b2f7a33115ab789fa2403c592655657e04d\",\"icon-maskable.png\":\"98caea4e0138a5272161323354bea3585ecac298ff8576823258aeddee01a45f\",\"icon.svg\":\"d12d71c61b9b10bf6b04ba84d91497c272291cd0830c21d5ca98ce2c771fabf2\",\"index.html\":\"b4735c9fcdcee84a3bc52d9f8f5ee7a2fbaed1e290d8a8b0a0aad6fe342f9b06\",\"page.webmanifest\":\"909a00587727949215a61974b50bfb8f15bda9c788e30bb4cdae5af19732dc86\"}");
/** What the page itself names: enough to say that the robot is away. */
const SHELL = JSON.parse("[\"index.html\",\"icon.svg\",\"icon-192.png\",\"page.webmanifest\",\"assets/index-DupXE_TZ.js\",\"assets/access-BhzJ2x1u.js\",\"assets/index-DrfhNA8_.css\"]");
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
