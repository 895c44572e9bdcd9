// Keeps the page for a robot that is off or far: the files that it was built with, each checked by its digest, and nothing
// else. What the robot says is never kept. The build fills in the names.
const BUILD = "140b885d34aa7548";
/** @type {Record<string, string>} */
const FILES = JSON.parse("{\"assets/Behaviours-_u35VjAf.js\":\"d2fc0ae3e6d60c4aaceee000da6e9be8898d974744629df1fe1755f28df50bbb\",\"assets/Behaviours-ju1TH5lu.css\":\"7df80eb0fe64b2ebddd196abb60e688fe2d0c3fdb01c7e65492934acb953265b\",\"assets/Below-BueRWy52.js\":\"4df35ee5728e8f9ed30535e742f0b43424016caa3e58c056bd0aec5e21210cd7\",\"assets/Call-B5myZyvC.css\":\"9bd95ba7d1077c3c66775bc4757281e32365e5b943c7bc7624cd626d4792f397\",\"assets/Call-DjS8iW53.js\":\"e5bd5e50476b4c84bda7071d2b5fa73eac5735218b9c0eaa0a6f59c482eefe19\",\"assets/Display-CWZ7p6xw.js\":\"55c50b1958f42ed20ee146920c3f8e456ff46e0a52532dc680b39e2726c8778d\",\"assets/Display-hbDRwTTd.css\":\"c83eeecb550859a06b9cd577a58e8c226d9ef24d37e0f7fb05ec1f901b52e67e\",\"assets/Drive-DA0oOCw8.css\":\"ca725096dee8c5c674a829996b919b267320060c09db2b5ba6b10b2fc80d0083\",\"assets/Drive-DvgF2DRd.js\":\"73fef1c2b05d4737ac56926e8dede8408121bd419b177a8b94d550b3180a0fde\",\"assets/Joints-BGUnxNTK.js\":\"afd3c3df3a47529e6d7ac7c0638e31657416093709767bf76105735a6766e716\",\"assets/Lacking-BArsJNkv.js\":\"32a868238454a596d3ddc31742eaee3c642499bf1f5ffd438b9acd6d7d1c4262\",\"assets/Lacking-CacvYTQJ.css\":\"c7c4f4a3d3af03716a518f6da6ec94b34d1ffc67385869d3316d0f32ce4ddef3\",\"assets/Log-DSh-8f-Z.js\":\"945fd42d2fb722c9bbfb96902daa40109e9c02f4b6ac41923e7373b55e0a98b2\",\"assets/Motions-BcakILH-.js\":\"4bd43b0216a3e6a0a56c13f60e844c522f7d093b84d1186a13d0677dec75e2f1\",\"assets/Motions-CaFlTiXz.css\":\"3ae2ef57347e7e60dc54ae7e27f44ce213a22abdda941217da9332eb71385719\",\"assets/System-Dpxql32k.js\":\"983530fefff23fa5bb4db5ebc28536a4f762b9575fe5448dbeec619e133264cd\",\"assets/System-DzGb0BSC.css\":\"24e170c69cd29e16f2088d6e853fad573a6835cf7d5736dadcb7954f3f03fb00\",\"assets/access-CDdFy0RP.js\":\"e6251fffbfcadce9a4379e494f348bde33ee768212c400f07bd8eff39437eddc\",\"assets/connection-COs4CRlx.js\":\"e791acecbf114dafdb2c3229eeddbbc9bd45e53777f4ac9f317e1804d173fd3c\",\"assets/data-bc0O4mvJ.js\":\"9f3ac50fb159473b5c84588fc919a59f3b872cc12d38154dc2f5087c02499357\",\"assets/index-DmlC93DY.js\":\"f575cb63dd99134977b40a57db79b9992ffcc240074dca5da1e7ecfe3d60e766\",\"assets/index-DrfhNA8_.css\":\"2a05279a6876bf121c01175a22aee496b2429adc0521a0755d636d146c10bdb3\",\"assets/manage-Avg8jEAX.js\":\"99084f02a55ad257fbce296a42b36506e01e75742e54b7c9a21a07be0d92eb28\",\"assets/model-BjR3jKsp.css\":\"e7b501306dc22d125bfd1c47dd9ad7e8822c5ccca5776778dd408da0b97061c5\",\"assets/model-COsTMLvT.js\":\"7b5bc7df13255125e2c7bb890742b5812e6ee3c0be9ab2123ebec6e5226ced73\",\"assets/news-DURmWClG.js\":\"50933a96b2effb42caf4e006cf9d7f9e50bda525b6b9f11f2506fd6e0057c7c3\",\"assets/parts-CSyIQmt4.js\":\"13c3e10a48b1e89904388dfbbc7f9587aab234199e223f28ddb778669534e429\",\"assets/stage-NltGCcRk.js\":\"a527e9e5ee1f85c7006f33d11558e9491fd9874463248b90ac2c7b2a69065a5d\",\"assets/stream-DXOIZQ6X.js\":\"f87f4a426982d09b8e1113e1795c4e42c091eea4a3c663878fbe66f4d7869828\",\"assets/uPlot-CnsZ1jie.css\":\"0fd9465202f6dfceac29e67c17e5ac9fb1b7ba7615c1bb08782391b791d9f1e0\",\"assets/uPlot.esm-BScb58at.js\":\"068506d72590b07d0e53e012ff1541813c52c09bded848b3f97fcd1d4b0fd3b2\",\"favicon.ico\":\"eb66fde2ce87c9f33228184353f8a8c7ff0517cd76eaf9d6a94759bbd7276be9\",\"icon-192.png\":\"df4dde7d57f1963226b36d9501a3b173c02eddc858bef226ae0176dbb4b7ee19\",\"icon-512.png\":\"6e797a05bab65afa3472b6a2bbc42b2f7a33115ab789fa2403c592655657e04d\",\"icon-maskable.png\":\"98caea4e0138a5272161323354bea3585ecac298ff8576823258aeddee01a45f\",\"icon.svg\":\"d12d71c61b9b10bf6b04ba84d91497c272291cd0830c21d5ca98ce2c771fabf2\",\"index.html\":\"6ea09cac613fcf455f43b341851b9b297a958d45c111ef525eaa46583489de99\",\"page.webmanifest\":\"909a00587727949215a61974b50bfb8f15bda9c788e30bb4cdae5af19732dc86\"}");
/** What the page itself names: enough to say that the robot is away. */
const SHELL = JSON.parse("[\"index.html\",\"icon.svg\",\"icon-192.png\",\"page.webmanifest\",\"assets/index-DmlC93DY.js\",\"assets/access-CDdFy0RP.js\",\"assets/parts-CSyIQmt4.js\",\"assets/index-DrfhNA8_.css\"]");
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
