"use strict";
// Shows the stream while somebody looks, and begins it anew when it ends.
const AGAIN_MS = 2000;
const view = document.getElementById("view");
const said = document.getElementById("said");
const links = document.getElementById("cameras");
const camera = new URLSearchParams(location.search).get("camera") || "";

if (location.hash) history.replaceState(null, "", location.pathname + location.search);

function begin() {
  if (document.hidden) return;
  const which = camera ? `camera=${encodeURIComponent(camera)}&` : "";
  view.src = `stream.mjpg?${which}at=${Date.now()}`;
}

function end() {
  view.hidden = true;
  view.removeAttribute("src");
}

view.addEventListener("load", () => { view.hidden = false; });
view.addEventListener("error", () => {
  if (!view.hasAttribute("src")) return;
  end();
  setTimeout(begin, AGAIN_MS);
});
document.addEventListener("visibilitychange", () => (document.hidden ? end() : begin()));

function link(name, text) {
  const made = document.createElement("a");
  made.href = name ? `index.html?camera=${encodeURIComponent(name)}` : "index.html";
  made.textContent = text;
  if (name === camera) made.setAttribute("aria-current", "page");
  return made;
}

function tell(states) {
  links.replaceChildren(link("", "current"), ...Object.keys(states).map((name) => link(name, `${name}: ${states[name].status}`)));
  const shown = Object.entries(states).filter(([name]) => !camera || name === camera);
  const streams = shown.some(([, state]) => state.phase === "streaming");
  const reasons = shown.map(([, state]) => state.reason).filter(Boolean);
  if (!streams) view.hidden = true;
  else if (view.naturalWidth) view.hidden = false;
  said.hidden = streams && !view.hidden;
  said.textContent = streams ? "Waiting for a picture…" : reasons.join(" ") || (shown.length ? "The camera is off." : "There is no camera.");
}

async function look() {
  try {
    const answer = await fetch("cameras");
    if (answer.status === 401) location.reload();
    tell(await answer.json());
  } catch {
    said.hidden = false;
    said.textContent = "The robot does not answer.";
  }
  setTimeout(look, AGAIN_MS);
}

document.getElementById("leave").addEventListener("click", async () => {
  end();
  try { await fetch("session", { method: "DELETE" }); } finally { location.reload(); }
});

begin();
look();
