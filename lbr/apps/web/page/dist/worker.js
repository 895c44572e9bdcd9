// Keeps the page for a robot that is off or far: the files that it was built with, each checked by its digest, and nothing
// else. What the robot says is never kept. The build fills in the names.
const BUILD = "85791bfccbec6c95";
/** @type {Record<string, string>} */
const FILES = JSON.parse("{\"assets/Behaviours-4akofgzr.js\":\"4736277539490373cf26ba10e8d5c032e5169f64e5b14860068cbe557b81328b\",\"assets/Behaviours-CW6UGM9H.css\":\"f8ec05f55e6ffeb2c0ecf622c8f86b9bcd1e9fc4197c1fb4ed8135c322d9d1a4\",\"assets/Below-CwrNJ2S6.js\":\"bc47522960e30f10ac84c4861448a15e417db6ed1ad6f7c874d92a4958833f8a\",\"assets/Call-B4NIIraA.js\":\"2cbfdfee7fda92232788e89963fad5ba037585a7fba2499f573e4562e683ae65\",\"assets/Call-BH-FlvRt.css\":\"72c27a044611bd5e73568c62521730576fefce8c2a7bc35fb38ab268f89da215\",\"assets/Display-DMfrqIXm.js\":\"9fb61f29a0f6076de2922fbaacdf000e1e40f1211e4f409ff9e5d366a218fd4a\",\"assets/Display-hbDRwTTd.css\":\"c83eeecb550859a06b9cd577a58e8c226d9ef24d37e0f7fb05ec1f901b52e67e\",\"assets/Drive-5d-UzAkK.js\":\"d315e8c3567bafc3a801c1104b30f958a543aabdef6b3d687f4da410e01f00aa\",\"assets/Drive-CguKo-Or.css\":\"502d412c4055f2c0f7d9d3a0c36f04fb07c4402f07fc5410662c1d7eb0c43be9\",\"assets/Joints-BV5Ih_Uu.js\":\"d57f552ebe43cb50f2d3360d4e36decfbfafd56fb8b49af204dbd3db235820a5\",\"assets/Lacking-BNdwUEd_.js\":\"4c412c199e37a6f37c3a46e3e7afef21b3d000fc656658574e42533f15849208\",\"assets/Lacking-CacvYTQJ.css\":\"c7c4f4a3d3af03716a518f6da6ec94b34d1ffc67385869d3316d0f32ce4ddef3\",\"assets/Log-506l9Lni.js\":\"252293e57cefdda69b10abed1bacb3d04f2f006d4e94518da7b37c9045f67d68\",\"assets/Motions-C9ztcZkJ.js\":\"71bc129157b8f40b34a4ee8fa4565336f64b23111ca252b0934280bbe67834df\",\"assets/Motions-CJQoRpbq.css\":\"da3e78579f8d170defd81f9b2104226e0f00b6d94db24d4203e26b51d8c102ac\",\"assets/System-BGnS4FCh.js\":\"a540ec7f8b1a6326e9c4ded406edd4f5715cf716b01d42935761bd0dd66b615c\",\"assets/System-CAGU8Dof.css\":\"ae933e9c36299104bd16c32c77243303a9aac415f91195177bf4a3e59a11cf9e\",\"assets/access-DWsm892u.js\":\"bf89a67a2744550c85a112eee9ba4e32c9bfca720239428c252abb53d0d56b1b\",\"assets/connection-zZfaeIsH.js\":\"0c66660f3e3d8596fb5674055410e72b23e2ee50da0c7bc17ddf8c2e4bc9dc98\",\"assets/data-bfvcHgUB.js\":\"a21a92824d4bc56564269ccdf424fb7944d25312e667faf3aabf620e4e6c3dd8\",\"assets/index-DWdO08Zv.css\":\"0cd8bc74e233b4a804728e823f79b07fd598f349fd123c2d8f28fb5db89f60d2\",\"assets/index-KmYFjQMe.js\":\"19f4e7d08d697028d43d746251a14fb8df9f0afbb81b400c90f466efa6df105c\",\"assets/manage-JFUe2lRQ.js\":\"abfbde2926d179f2cb90ccaf805afab329525681eec640c06efc0e51d0430f3c\",\"assets/model-BhDZKaW7.css\":\"6c5740c3b5ac779d9bac281576b4fbb48c5da54a165bce2a4712f8052b110d74\",\"assets/model-CMkjmvsj.js\":\"f80d373bff1746ee781eb99df7b4b68eba9ee947e8b7f996783f1544737b2cd9\",\"assets/news-DurGXe0N.js\":\"abb0affdc6a925fab4fd69ad4b7d94d0b101fff615428c82cb3bb0348f0db49e\",\"assets/parts-C8LavGFo.js\":\"a63cba8c8b15ac6a6d70ab56f24d10fd6387db4dcc155c4b660f30df98436e1d\",\"assets/stage-DZ0M97V9.js\":\"ca28469079e08cc1439797c05bd44838d4b8a094509d650f959e771b44ca274f\",\"assets/stream-BUEtR2An.js\":\"d881972db5cd27a16bfebc26edf70ae0d0d35d9207364c148b05e0a8a3e49e6b\",\"assets/uPlot-CnsZ1jie.css\":\"0fd9465202f6dfceac29e67c17e5ac9fb1b7ba7615c1bb08782391b791d9f1e0\",\"assets/uPlot.esm-BScb58at.js\":\"068506d72590b07d0e53e012ff1541813c52c09bded848b3f97fcd1d4b0fd3b2\",\"favicon.ico\":\"eb66fde2ce87c9f33228184353f8a8c7ff0517cd76eaf9d6a94759bbd7276be9\",\"icon-192.png\":\"df4dde7d57f1963226b36d9501a3b173c02eddc858bef226ae0176dbb4b7ee19\",\"icon-512.png\":\"6e797a05bab65afa3472b6a2bbc42b2f7a33115ab789fa2403c592655657e04d\",\"icon-maskable.png\":\"98caea4e0138a5272161323354bea3585ecac298ff8576823258aeddee01a45f\",\"icon.svg\":\"d12d71c61b9b10bf6b04ba84d91497c272291cd0830c21d5ca98ce2c771fabf2\",\"index.html\":\"3fa9e53956dd9671043b9b122f0bd988c37fc10f17383358b9606c9a1648af49\",\"page.webmanifest\":\"909a00587727949215a61974b50bfb8f15bda9c788e30bb4cdae5af19732dc86\"}");
/** What the page itself names: enough to say that the robot is away. */
const SHELL = JSON.parse("[\"index.html\",\"icon.svg\",\"icon-192.png\",\"page.webmanifest\",\"assets/index-KmYFjQMe.js\",\"assets/access-DWsm892u.js\",\"assets/parts-C8LavGFo.js\",\"assets/index-DWdO08Zv.css\"]");
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
