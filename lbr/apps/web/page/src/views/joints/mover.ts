// Moving joints by hand: while a slider or a limb is held, and after that until the joint has arrived or takes too long.
import { signal } from "@preact/signals";
import { holding } from "../../holding";
import { NEAR_RAD } from "./tone";

export const SPEEDS = { slow: 0.4, normal: 1.2, fast: 3 } as const;
export type Speed = keyof typeof SPEEDS;
export const speed = signal<Speed>("normal");

/** What joints are on their way to, from the moment that it is asked for; what the robot says comes later. */
export const aims = signal<Record<string, number>>({});

const PATIENCE_MS = 1500;
const RESTED_MS = 250;
interface Aim { rad: number; until: number; near: number | null }

/** Decides when a joint is done; the clock and what moves it are given, so that it can be tried without a robot. */
export class Mover {
  private readonly going = new Map<string, Aim>();
  private held = "";

  constructor(
    private readonly send: (positions: Record<string, number>) => boolean,
    private readonly release: () => void,
    private readonly now: () => number = () => performance.now(),
  ) {}

  /** Has a joint go there; `held`: a hand is still on it, so that it does not end. */
  aim(joint: string, rad: number, from: number | null, rps: number, held: boolean): boolean {
    if (this.going.size === 0) this.release();
    const others = Object.fromEntries([...this.going].map(([name, aim]) => [name, aim.rad]));
    if (!this.send({ ...others, [joint]: rad })) {
      this.forget();
      return false;
    }
    this.held = held ? joint : this.held === joint ? "" : this.held;
    const takes = from === null ? 4000 : (1000 * Math.abs(rad - from)) / Math.max(0.05, rps);
    this.going.set(joint, { rad, until: this.now() + 1.5 * takes + PATIENCE_MS, near: null });
    this.tell();
    return true;
  }

  /** The hand is off. */
  drop(): void {
    this.held = "";
  }

  /** Takes in where joints are, and ends what has arrived. */
  seen(positions: Record<string, number | null | undefined>): void {
    if (this.going.size === 0) return;
    const now = this.now();
    for (const [joint, aim] of this.going) {
      const at = positions[joint];
      const near = at != null && Math.abs(at - aim.rad) <= NEAR_RAD;
      aim.near = near ? aim.near ?? now : null;
      const done = (aim.near !== null && now - aim.near > RESTED_MS) || now > aim.until;
      if (done && joint !== this.held) this.going.delete(joint);
    }
    this.tell();
    if (this.going.size === 0) this.release();
  }

  /** What moved was ended from elsewhere. */
  forget(): void {
    this.held = "";
    if (this.going.size === 0) return;
    this.going.clear();
    this.tell();
  }

  private tell(): void {
    const told = Object.fromEntries([...this.going].map(([joint, aim]) => [joint, aim.rad]));
    if (JSON.stringify(told) !== JSON.stringify(aims.value)) aims.value = told;
  }
}

/** Moves the joints of all capabilities, those of one at a time: they join what moves already, and stay held until all have arrived. */
export class Movers {
  private owner = "";
  private readonly mover = new Mover(
    (positions) => holding.move(`${this.owner}/command`, { positions, speed_rps: SPEEDS[speed.value], join: true, stay: true }),
    () => holding.release(),
  );

  aim(owner: string, joint: string, rad: number, from: number | null, rps: number, held: boolean): boolean {
    if (owner !== this.owner) this.mover.forget();
    this.owner = owner;
    return this.mover.aim(joint, rad, from, rps, held);
  }

  drop(): void { this.mover.drop(); }
  seen(positions: Record<string, number | null | undefined>): void { this.mover.seen(positions); }
  forget(): void { this.mover.forget(); }
}
