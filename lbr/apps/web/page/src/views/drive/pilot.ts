// The hand on the robot: thumb, keys and gamepad become one aim, which the socket holds.
import { effect, signal } from "@preact/signals";
import { holding, refused } from "../../holding";
import { remember, remembered } from "../../kept";
import type { Robot } from "../../messages";
import { may, robot } from "../../robot";
import { aim, alike, ofKeys, together, twist, type Aim, type Push, type Twist } from "../../stick";
import { stop } from "../../stopping";

/** How much of what the robot's settings allow is given at most; chosen by the slider, kept by the browser. */
export const top = signal<number>(remembered("top", 0.4));
/** Where the stick is, for the picture of it. */
export const hand = signal<Push>({ x: 0, y: 0, turn: 0 });
export const gamepad = signal("");

effect(() => remember("top", top.value));

const SLOW = 0.5;
const DRIVES = new Set(["ArrowUp", "ArrowDown", "ArrowLeft", "ArrowRight", "KeyW", "KeyA", "KeyS", "KeyD"]);
const TURNS = new Set(["KeyQ", "KeyE"]);
const TYPED = "input:not([type=range]):not([type=checkbox]), textarea, select, [role=dialog]";
/** What arrow keys mean something to by itself. */
const ARROWED = "input[type=range], [role=radiogroup]";
const sources = new Map<string, Push>();
const held = new Set<string>();
const driver = signal("");
let slow = false;
/** The gamepad's sticks were seen at rest since it came, or since the page had no hand on it. */
let rested = false;
let last: Aim | Twist | null = null;

function update(): void {
  hand.value = together(sources.values());
  if (document.hidden) {
    if (last !== null) holding.release();
    last = null;
    return;
  }
  const wanted = may("operate") ? wish(hand.value, top.value * (slow ? SLOW : 1)) : null;
  if (wanted === null) {
    if (last !== null || refused.value) holding.release();
    last = null;
    refused.value = false;
    return;
  }
  if (refused.value) return;
  if (last === null) holding.forget();
  if (!alike(last, wanted) || !holding.state.value.moving) {
    refused.value = !holding.move(`${driver.value}/${sideways() ? "twist" : "command"}`, wanted);
  }
  last = wanted;
}

/** What is driven, where the robot tells of it. */
export const base = (): Robot["base"] => (robot.value?.base?.capability === driver.value ? robot.value.base : null);
/** Whether the base goes sideways: then the stick does so, and turning has a control of its own. */
export const sideways = (): boolean => base()?.sideways === true;

function wish(push: Push, most: number): Aim | Twist | null {
  const driven = base();
  return driven?.sideways ? twist(push, driven, most) : aim(push.x, push.y, most * (driven?.max_power ?? 1));
}

/** Notes where a source's stick is; at rest it counts no more. */
export function push(source: string, x: number, y: number, turn = 0): void {
  if (x === 0 && y === 0 && turn === 0) sources.delete(source);
  else sources.set(source, { x, y, turn });
  update();
}

/** Takes every hand off; a thumb that is still on the stick has to be lifted first. */
function rest(): void {
  const pushed = sources.has("stick") || sources.has("turn");
  sources.clear();
  held.clear();
  rested = false;
  update();
  refused.value = pushed;
}

/** Listens to keys and gamepads for the capability that drives until the returned function is called. */
export function listenToHands(name: string): () => void {
  driver.value = name;
  const press = (): void => {
    const { x, y, turn } = ofKeys(held);
    push("keys", x, y, turn);
  };
  const down = (event: KeyboardEvent): void => {
    const target = event.target instanceof Element ? event.target : document.body;
    if (event.ctrlKey || event.metaKey || event.altKey || target.closest(TYPED)) return;
    if (event.code.startsWith("Arrow") && target.closest(ARROWED)) return;
    slow = event.shiftKey;
    if (!DRIVES.has(event.code) && !(sideways() && TURNS.has(event.code))) return update();
    event.preventDefault();
    // A key that was pressed elsewhere, or before the window lost the focus, only repeats.
    if (event.repeat && !held.has(event.code)) return;
    held.add(event.code);
    press();
  };
  const up = (event: KeyboardEvent): void => {
    slow = event.shiftKey;
    if (event.key === "Escape") held.clear();
    held.delete(event.code);
    press();
  };
  const hidden = (): void => { if (document.hidden) rest(); };
  const ended = effect(() => {
    // Whatever ended it, a stop or a loss: a hand that is still on the stick begins nothing by itself.
    if (holding.state.value.moving || last === null) return;
    refused.value = true;
  });
  const pads = listenToGamepads();
  window.addEventListener("keydown", down);
  window.addEventListener("keyup", up);
  window.addEventListener("blur", rest);
  document.addEventListener("visibilitychange", hidden);
  return () => {
    window.removeEventListener("keydown", down);
    window.removeEventListener("keyup", up);
    window.removeEventListener("blur", rest);
    document.removeEventListener("visibilitychange", hidden);
    ended();
    pads();
    rest();
  };
}

const PAD_DEAD = 0.16;
const B = 1;

function listenToGamepads(): () => void {
  let frame = 0;
  let stopping = false;
  rested = false;
  const poll = (): void => {
    frame = 0;
    const pad = navigator.getGamepads?.().find((one) => one?.connected) ?? null;
    gamepad.value = pad?.id ?? "";
    if (!pad) {
      rested = false;
      return push("gamepad", 0, 0);
    }
    const [x = 0, y = 0, turn = 0] = pad.axes;
    const pushed = Math.hypot(x, y) > PAD_DEAD;
    const turned = sideways() && Math.abs(turn) > PAD_DEAD;
    rested ||= document.hasFocus() && !pushed && !turned;
    push("gamepad", rested && pushed ? x : 0, rested && pushed ? -y : 0, rested && turned ? turn : 0);
    const b = pad.buttons[B]?.pressed ?? false;
    if (b && !stopping) void stop();
    stopping = b;
    frame = requestAnimationFrame(poll);
  };
  const wake = (): void => { if (!frame) frame = requestAnimationFrame(poll); };
  const changed = (): void => {
    rested = false;
    wake();
  };
  window.addEventListener("gamepadconnected", changed);
  window.addEventListener("gamepaddisconnected", changed);
  wake();
  return () => {
    cancelAnimationFrame(frame);
    window.removeEventListener("gamepadconnected", changed);
    window.removeEventListener("gamepaddisconnected", changed);
  };
}
