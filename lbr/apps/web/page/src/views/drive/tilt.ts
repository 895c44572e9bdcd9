// Tilting the phone as a stick: only while a thumb rests on the field, from how the phone lay when it was put there.
import { signal } from "@preact/signals";
import { notice } from "../../notices";
import { t } from "../../words";

/** So far tilted the stick is at its end. */
const FULL_RAD = (25 * Math.PI) / 180;
/** Phones tell of their tilt many times a second; one that is silent for so long is taken to have no sensor any more. */
const SILENT_MS = 700;
interface Asks { requestPermission?: () => Promise<"granted" | "denied"> }
export type Vector = readonly [number, number, number];

/** Phones and tablets have it, where the page came by a line that browsers trust. */
export const canTilt = (): boolean => "DeviceOrientationEvent" in window && isSecureContext && matchMedia("(pointer: coarse)").matches;
/** Off until it is asked for, with each page. */
export const tilts = signal<boolean>(false);

/** Switches it; some phones ask their user first. */
export async function tilt(on: boolean): Promise<void> {
  const asks = DeviceOrientationEvent as unknown as Asks;
  const granted = !on || !asks.requestPermission || (await asks.requestPermission().catch(() => "denied")) === "granted";
  if (!granted) notice(t("drive.tilt.denied"), "warn");
  tilts.value = on && granted;
}

/** Which way is up, as the phone sees it: x to the right of its screen, y to its top, z out of it. */
export function up(beta: number, gamma: number): Vector {
  const [b, g] = [(beta * Math.PI) / 180, (gamma * Math.PI) / 180];
  return [-Math.cos(b) * Math.sin(g), Math.sin(b), Math.cos(b) * Math.cos(g)];
}

const dot = (one: Vector, other: Vector): number => one[0] * other[0] + one[1] * other[1] + one[2] * other[2];
const cross = (one: Vector, other: Vector): Vector => [one[1] * other[2] - one[2] * other[1], one[2] * other[0] - one[0] * other[2], one[0] * other[1] - one[1] * other[0]];

/**
 * From how a phone was held and is held to a stick: by where up is, which goes smoothly however it is held, and not by its angles, which jump where a screen
 * stands upright. A phone whose screen's right looks up or down says nothing.
 */
export function stickOf(from: Vector, now: Vector, screenDeg: number): { x: number; y: number } {
  const turn = (screenDeg * Math.PI) / 180;
  const side: Vector = [Math.cos(turn), -Math.sin(turn), 0];
  const lean = dot(side, from);
  const level: Vector = [side[0] - lean * from[0], side[1] - lean * from[1], side[2] - lean * from[2]];
  const length = Math.hypot(...level);
  const across = cross(now, from);
  const sine = Math.hypot(...across);
  if (!(length > 0.3) || !(sine > 1e-6)) return { x: 0, y: 0 };
  const right: Vector = [level[0] / length, level[1] / length, level[2] / length];
  const scale = Math.atan2(sine, dot(now, from)) / sine / FULL_RAD;
  const [x, y] = [dot(across, cross(from, right)) * scale, -dot(across, right) * scale];
  const far = Math.max(1, Math.hypot(x, y));
  return { x: x / far, y: y / far };
}

/** Follows the phone until the returned function is called; one that falls silent is at rest. */
export function follow(push: (x: number, y: number) => void): () => void {
  let from: Vector | null = null;
  const silent = (): void => {
    window.removeEventListener("deviceorientation", turned);
    push(0, 0);
    if (from === null) notice(t("drive.tilt.silent"), "warn");
  };
  let patience = setTimeout(silent, SILENT_MS);
  const turned = ({ beta, gamma }: DeviceOrientationEvent): void => {
    if (beta === null || gamma === null || !Number.isFinite(beta) || !Number.isFinite(gamma)) return push(0, 0);
    clearTimeout(patience);
    patience = setTimeout(silent, SILENT_MS);
    const now = up(beta, gamma);
    from ??= now;
    const { x, y } = stickOf(from, now, screen.orientation?.angle ?? 0);
    push(x, y);
  };
  window.addEventListener("deviceorientation", turned);
  return () => {
    clearTimeout(patience);
    window.removeEventListener("deviceorientation", turned);
  };
}
