// Tilting the phone as a stick: only while a thumb rests on the field, from how the phone lay when it was put there.
import { signal } from "@preact/signals";
import { remember, remembered } from "../../kept";

const FULL_DEG = 25;
interface Asks { requestPermission?: () => Promise<"granted" | "denied"> }

/** Phones and tablets have it, where the page came by a line that browsers trust. */
export const canTilt = (): boolean => "DeviceOrientationEvent" in window && isSecureContext && matchMedia("(pointer: coarse)").matches;
export const tilts = signal<boolean>(canTilt() && remembered("tilt", false));

/** Switches it; some phones ask their user first. */
export async function tilt(on: boolean): Promise<void> {
  const asks = DeviceOrientationEvent as unknown as Asks;
  tilts.value = on && (!asks.requestPermission || (await asks.requestPermission().catch(() => "denied")) === "granted");
  remember("tilt", tilts.value);
}

/** From how far a phone was tilted and how its screen stands to a stick. Pure. */
export function stickOf(beta: number, gamma: number, screenDeg: number): { x: number; y: number } {
  const turn = (screenDeg * Math.PI) / 180;
  const [right, ahead] = [gamma / FULL_DEG, -beta / FULL_DEG];
  const x = right * Math.cos(turn) - ahead * Math.sin(turn);
  const y = right * Math.sin(turn) + ahead * Math.cos(turn);
  const far = Math.max(1, Math.hypot(x, y));
  return { x: x / far, y: y / far };
}

/** Follows the phone until the returned function is called. */
export function follow(push: (x: number, y: number) => void): () => void {
  let from: { beta: number; gamma: number } | null = null;
  const turned = ({ beta, gamma }: DeviceOrientationEvent): void => {
    if (beta === null || gamma === null) return push(0, 0);
    from ??= { beta, gamma };
    const { x, y } = stickOf(beta - from.beta, gamma - from.gamma, screen.orientation?.angle ?? 0);
    push(x, y);
  };
  window.addEventListener("deviceorientation", turned);
  return () => window.removeEventListener("deviceorientation", turned);
}
