// One joint: how it is, a slider and a number, its torque; more of it when it is chosen.
import { useRef, useState } from "preact/hooks";
import { inWords } from "../../access";
import { degrees, number, percent } from "../../format";
import { Badge, Button, Icon, useOwnId, type IconName } from "../../parts";
import { jointName, maybe, t } from "../../words";
import type { JointRange, JointState } from "./model";
import { BADGE, toneOf, type Tone } from "./tone";

const ICON: Record<Tone, IconName> = { near: "check", held: "check", moving: "play", loaded: "warn", fault: "warn", hot: "heat", limp: "power", unread: "unlink", doubt: "info" };
const STEP_RAD = Math.PI / 360;
const inDegrees = (rad: number): number => Math.round((1800 * rad) / Math.PI) / 10;

/** A name without the side that stands above it. */
const within = (name: string, side: string): string => (name.startsWith(`${side}_`) ? name.slice(side.length + 1) : name);

export interface RowProps {
  name: string;
  range: JointRange;
  state: JointState | undefined;
  aim: number | undefined;
  selected: boolean;
  may: boolean;
  onPick: (joint: string) => void;
  onMove: (joint: string, rad: number, held: boolean) => void;
  onTorque: (joint: string, on: boolean) => void;
  onRecover: (joint: string) => void;
}

export function Row({ name, range, state, aim, selected, may, onPick, onMove, onTorque, onRecover }: RowProps) {
  const tone = toneOf(state);
  const [lower, upper] = [range.lower ?? -Math.PI, range.upper ?? Math.PI];
  const at = state?.position_rad ?? null;
  const limp = state?.torque === 0;
  const holds = state?.torque != null && !limp;
  const can = may && !limp && at !== null && tone !== "fault";
  const word = t(`joints.tone.${tone}`);
  return (
    <li class="joints-row" data-tone={tone} data-joint={name} aria-current={selected || undefined}>
      <div class="joints-row-head">
        <button type="button" class="joints-name" aria-expanded={selected} onClick={() => onPick(selected ? "" : name)}>
          <span class="joints-dot" title={word}><Icon name={ICON[tone]} /></span>
          <span class="joints-name-text">{jointName(within(name, range.side))}</span>
          <span class="sr">{word}</span>
        </button>
        <Angle name={name} at={aim ?? at} lower={lower} upper={upper} disabled={!can} onMove={onMove} />
        <Button
          kind="quiet" class="joints-lock" icon={holds ? "bolt" : "power"} pressed={holds} disabled={!may || !state}
          label={t(holds ? "joints.release.one" : "joints.lock.one", { joint: jointName(name) })} onClick={() => onTorque(name, !holds)}
        />
      </div>
      <Range name={name} at={at} aim={aim} lower={lower} upper={upper} disabled={!can} onMove={onMove} onFocus={() => { if (!selected) onPick(name); }} />
      {selected && <Details state={state} tone={tone} range={range} may={may} onRecover={() => onRecover(name)} />}
    </li>
  );
}

function Range({ name, at, aim, lower, upper, disabled, onMove, onFocus }: { name: string; at: number | null; aim?: number; lower: number; upper: number; disabled: boolean; onMove: RowProps["onMove"]; onFocus: () => void }) {
  const [held, hold] = useState<number | null>(null);
  const part = (rad: number): number => Math.min(100, Math.max(0, (100 * (rad - lower)) / (upper - lower || 1)));
  const shown = held ?? aim ?? at ?? Math.min(upper, Math.max(lower, 0));
  const zero = part(0);
  const is = at === null ? zero : part(at);
  const look = { "--from": `${Math.min(zero, is)}%`, "--to": `${Math.max(zero, is)}%`, "--is": `${is}%` } as Record<string, string>;
  return (
    <div class="joints-range" style={look}>
      <span class="joints-range-end">{degrees(lower)}</span>
      <span class="joints-track">
        <input
          type="range" min={lower} max={upper} step={STEP_RAD} value={shown} disabled={disabled} aria-label={jointName(name)} aria-valuetext={degrees(shown, 1)}
          onFocus={onFocus}
          onInput={(event) => { hold(event.currentTarget.valueAsNumber); onMove(name, event.currentTarget.valueAsNumber, true); }}
          onChange={(event) => { onMove(name, event.currentTarget.valueAsNumber, false); hold(null); }}
          onPointerUp={() => hold(null)} onPointerCancel={() => hold(null)} onBlur={() => hold(null)}
        />
      </span>
      <span class="joints-range-end">{degrees(upper)}</span>
    </div>
  );
}

/** The angle as a number to type; what the robot says is not heeded while it is being typed. */
function Angle({ name, at, lower, upper, disabled, onMove }: { name: string; at: number | null; lower: number; upper: number; disabled: boolean; onMove: RowProps["onMove"] }) {
  const [typed, type] = useState<string | null>(null);
  const id = useOwnId();
  const parsed = (text: string): number => (text.trim() === "" ? NaN : Number(text.replace(",", ".")));
  const fits = (value: number): boolean => value >= inDegrees(lower) - 0.05 && value <= inDegrees(upper) + 0.05;
  const wrong = typed !== null && !fits(parsed(typed));
  const editing = useRef(false);
  const send = (text: string): void => {
    if (!editing.current) return;
    editing.current = false;
    if (fits(parsed(text))) onMove(name, Math.min(upper, Math.max(lower, (parsed(text) * Math.PI) / 180)), false);
    type(null);
  };
  return (
    <span class="joints-angle" data-wrong={wrong || undefined}>
      <input
        id={id} class="joints-number" inputMode="decimal" autocomplete="off" disabled={disabled} aria-label={t("joints.angle", { joint: jointName(name) })} aria-invalid={wrong}
        title={t("joints.limits", { lower: degrees(lower), upper: degrees(upper) })}
        value={typed ?? (at === null ? "–" : number((at * 180) / Math.PI, 1, "en"))}
        onFocus={(event) => { type(event.currentTarget.value); event.currentTarget.select(); }}
        onInput={(event) => { editing.current = true; type(event.currentTarget.value); }}
        onKeyDown={(event) => {
          if (event.key === "Enter") { send(event.currentTarget.value); event.currentTarget.blur(); }
        }}
        onBlur={(event) => { send(event.currentTarget.value); type(null); }}
      />
      <span aria-hidden="true">°</span>
    </span>
  );
}

function Details({ state, tone, range, may, onRecover }: { state: JointState | undefined; tone: Tone; range: JointRange; may: boolean; onRecover: () => void }) {
  const faults = [...new Set([...(state?.latched ?? []), ...(state?.faults ?? [])])];
  const goal = state?.target_rad ?? state?.goal_rad;
  const facts: [string, string][] = [
    [t("joints.goal"), degrees(goal, 1)],
    [t("joints.load"), percent(state?.load == null ? null : Math.abs(state.load))],
    [t("joints.temperature"), state?.temperature_c == null ? "–" : `${number(state.temperature_c)} °C`],
    [t("joints.voltage"), state?.voltage_v == null ? "–" : `${number(state.voltage_v, 1)} V`],
    [t("joints.strength"), state?.torque == null ? t("joints.unknown") : state.torque === 0 ? t("joints.off") : percent(state.torque)],
    [t("joints.servo"), state ? String(state.id) : "–"],
  ];
  return (
    <div class="joints-details">
      <p class="joints-details-head"><Badge tone={BADGE[tone]} icon={ICON[tone]}>{t(`joints.tone.${tone}`)}</Badge>{!range.drawn && <Badge>{t("joints.undrawn")}</Badge>}</p>
      {faults.length > 0 && (
        <p class="joints-fault">
          {t("joints.faults", { faults: faults.map((one) => maybe(`joints.fault.${one}`) || one.replaceAll("_", " ")).join(", ") })}
          {state?.latched?.length ? <Button icon="restart" disabled={!may} onClick={onRecover}>{t("joints.recover")}</Button> : null}
        </p>
      )}
      {state?.reason && <p class="joints-reason">{inWords(state)}</p>}
      <dl class="joints-facts">{facts.map(([what, value]) => <div key={what}><dt>{what}</dt><dd>{value}</dd></div>)}</dl>
    </div>
  );
}
