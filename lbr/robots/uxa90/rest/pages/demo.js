"use strict";

const at = (id) => document.getElementById(id);
const said = (text) => { at("said").textContent = text; };
const EVERY_MS = 100;

let token = sessionStorage.getItem("token") || "";

async function ask(path, options = {}) {
  try {
    const headers = { ...options.headers, ...(token ? { Authorization: `Bearer ${token}` } : {}) };
    const answer = await fetch(`/${path}`, { ...options, headers });
    if (answer.status === 401) at("signin").hidden = false;
    const body = await answer.json().catch(() => ({}));
    said(answer.ok ? "" : body.message || `status ${answer.status}`);
    return answer.ok ? body : null;
  } catch (err) {
    said(`no answer: ${err.message}`);
    return null;
  }
}

const post = (path, body) => ask(path, {
  method: "POST",
  headers: { "Content-Type": "application/json" },
  body: JSON.stringify(body || {}),
});

/* A slider asks at most ten times a second, and always for where it ended. */
function slider(id, motor) {
  const input = at(`${id}_to`);
  let busy = false, wanted = null;
  const send = async () => {
    if (busy || wanted === null) return;
    busy = true;
    const to = wanted;
    wanted = null;
    await post("multimotor", { motors: [{ id: motor, pos: to, torq: 2 }] });
    setTimeout(() => { busy = false; send(); }, EVERY_MS);
  };
  input.addEventListener("input", () => {
    at(`${id}_at`).textContent = input.value;
    wanted = Number(input.value);
    send();
  });
  ask(`motor?id=${motor}`).then((answer) => {
    if (!answer) return;
    input.min = answer.data.min;
    input.max = answer.data.max;
    input.value = answer.data.position;
    at(`${id}_at`).textContent = input.value;
  });
}

async function motions() {
  const answer = await ask("motion");
  for (const motion of answer ? answer.data : []) {
    const button = document.createElement("button");
    button.textContent = `${motion.id}. ${motion.name.replaceAll("_", " ")}`;
    button.addEventListener("click", () => post(`motion/${motion.id}`));
    at("motions").append(button);
  }
}

const degrees = (joint) => joint && typeof joint.position_rad === "number"
  ? `${Math.round(joint.position_rad * 180 / Math.PI)}°` : "not known";

function show(state) {
  const joints = state.joints || {}, controller = state.controller || {}, own = (state.faces || {}).uxa90 || {};
  const estop = Boolean(joints.estop);
  at("mode").textContent = controller.mode || "not heard";
  at("busy").textContent = own.busy ? (/'([^']+)'/.exec(own.busy) || ["", "a motion"])[1].replaceAll("_", " ") : "nothing";
  at("holder").textContent = joints.holder || "nobody";
  at("neck").textContent = degrees((joints.joints || {}).neck_yaw);
  at("head").textContent = degrees((joints.joints || {}).head_pitch);
  at("state").textContent = estop ? joints.reason || "emergency stop" : own.busy || joints.reason || "ready";
  at("state").className = estop ? "bad" : "";
  at("reset").hidden = !estop;
  for (const button of at("motions").children) button.disabled = estop || Boolean(own.busy);
}

function listen() {
  const scheme = location.protocol === "https:" ? "wss:" : "ws:";
  const protocols = token ? ["lbr.state", `bearer.${token}`] : ["lbr.state"];
  const socket = new WebSocket(`${scheme}//${location.host}/ws?rate_hz=5`, protocols);
  socket.addEventListener("message", (event) => show(JSON.parse(event.data)));
  socket.addEventListener("close", () => {
    at("state").textContent = "not connected";
    at("state").className = "bad";
    setTimeout(listen, 1000);
  });
}

at("signin").addEventListener("submit", (event) => {
  event.preventDefault();
  sessionStorage.setItem("token", at("token").value.trim());
  location.reload();
});
at("stop").addEventListener("click", () => post("stop"));
at("estop").addEventListener("click", () => post("estop", { reason: "pressed on the page" }));
at("reset").addEventListener("click", () => post("estop/reset"));
slider("neck", 23);
slider("head", 24);
motions();
listen();
