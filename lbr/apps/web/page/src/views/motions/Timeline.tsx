// The time line: key frames where they are reached, dragged earlier or later, how well it stands above them, pictures below.
import { useMemo, useRef, useState } from "preact/hooks";
import { number } from "../../format";
import { t } from "../../words";
import type { BodyModel } from "../joints/model";
import { onSheet, type Report } from "./balance";
import type { KeyFrame } from "./data";
import { change, chosen, index, sheet } from "./desk";
import { Figure } from "./Figure";
import { lasts, poseAt, reached, timed } from "./sheet";

const MOST_SHOWN = 48;
/** What is shown below the line, as a share of what is above it. */
const BELOW = 0.75;
const STEPS_S = [0.1, 0.2, 0.5, 1, 2, 5, 10, 30, 60, 120, 300] as const;

interface Props { model: BodyModel; time: number | null; wrong: ReadonlySet<number>; report: Report | null; onTime: (s: number | null) => void }

export function Timeline({ model, time, wrong, report, onTime }: Props) {
  const { frames } = sheet.value;
  if (frames.length === 0) return <p class="motions-hint motions-empty">{t("motions.build.empty")}</p>;
  return (
    <div class="motions-line">
      <Track frames={frames} time={time} wrong={wrong} report={report} onTime={onTime} />
      <Strip model={model} frames={frames} wrong={wrong} onChoose={(at) => { onTime(null); chosen.value = at; }} />
    </div>
  );
}

function Track({ frames, time, wrong, report, onTime }: { frames: KeyFrame[] } & Omit<Props, "model">) {
  const lane = useRef<HTMLDivElement>(null);
  // While a key frame is dragged the scale stays, or the last one runs away from the finger.
  const [held, hold] = useState<number | null>(null);
  const whole = held ?? Math.max(0.1, lasts(frames));
  const ends = reached(frames);
  const at = time ?? ends[index.value] ?? 0;
  const part = (s: number): string => `${(100 * Math.min(whole, Math.max(0, s))) / whole}%`;
  const under = (event: PointerEvent): number => {
    const box = lane.current!.getBoundingClientRect();
    return (whole * Math.max(0, event.clientX - box.left)) / box.width;
  };
  const scrub = (event: PointerEvent): void => {
    if ((event.target as HTMLElement).closest(".motions-knot")) return;
    (event.currentTarget as HTMLElement).setPointerCapture(event.pointerId);
    onTime(Math.min(whole, under(event)));
  };
  const step = STEPS_S.find((one) => whole / one <= 14) ?? 600;
  return (
    <div class="motions-track" role="group" aria-label={t("motions.times.frames")}>
      <div
        class="motions-lane" ref={lane} style={{ minWidth: `${Math.min(4000, frames.length * 16)}px` }}
        onPointerDown={scrub} onPointerMove={(event) => { if (event.buttons && (event.currentTarget as HTMLElement).hasPointerCapture(event.pointerId)) onTime(Math.min(whole, under(event))); }}
      >
        {report && <Ground report={report} frames={frames} whole={whole} />}
        <div class="motions-ruler" aria-hidden="true">
          {Array.from({ length: Math.floor(whole / step) + 1 }, (_, tick) => <span key={tick} style={{ left: part(tick * step) }}>{number(tick * step, step < 1 ? 1 : 0)}</span>)}
        </div>
        <div class="motions-rail" aria-hidden="true"><span style={{ width: part(at) }} /></div>
        {frames.length <= 400 && ends.map((s, frame) => <Knot key={frame} frame={frame} left={part(s)} s={s} chosen={frame === index.value} wrong={wrong.has(frame)} under={under} onTime={onTime} onHold={(is) => hold(is ? whole : null)} />)}
        <div class="motions-head" style={{ left: part(at) }} aria-hidden="true" data-on={time !== null || undefined} />
      </div>
    </div>
  );
}

let gestures = 0;

interface KnotProps { frame: number; left: string; s: number; chosen: boolean; wrong: boolean; under: (event: PointerEvent) => number; onTime: (s: number | null) => void; onHold: (is: boolean) => void }

function Knot({ frame, left, s, chosen: is, wrong, under, onTime, onHold }: KnotProps) {
  const moved = useRef(false);
  const gesture = useRef(0);
  const shift = (event: PointerEvent): void => {
    if (!event.buttons || !(event.currentTarget as HTMLElement).hasPointerCapture(event.pointerId)) return;
    const to = under(event);
    if (!moved.current && Math.abs(to - s) < 0.04) return;
    moved.current = true;
    change(timed(sheet.value, frame, Math.round(to * 20) / 20), `time-${frame}-${gesture.current}`, Infinity);
  };
  return (
    <button
      type="button" class="motions-knot" style={{ left }} data-wrong={wrong || undefined} aria-pressed={is} tabIndex={is ? 0 : -1}
      aria-label={t("motions.knot", { frame: frame + 1, s: number(s, 2) })}
      onPointerDown={(event) => { moved.current = false; gesture.current = ++gestures; onTime(null); chosen.value = frame; onHold(true); (event.currentTarget as HTMLElement).setPointerCapture(event.pointerId); }}
      onPointerMove={shift} onLostPointerCapture={() => onHold(false)}
      onClick={() => { onTime(null); chosen.value = frame; }}
    />
  );
}

/** How far the centre of mass is within what carries it, over time: above the line it stands, below it tips. */
function Ground({ report, frames, whole }: { report: Report; frames: KeyFrame[]; whole: number }) {
  const most = useMemo(() => Math.max(20, ...report.trace.map(({ margin_mm }) => margin_mm ?? 0)) * 1.12, [report]);
  const line = useMemo(() => {
    const points = onSheet(report, frames).filter(({ sample }) => sample.margin_mm != null && (report.falls_s == null || sample.t_s <= report.falls_s)).map(({ s, sample }) => [(1000 * s) / whole, high(sample.margin_mm!, most)] as const);
    return points.map(([x, y]) => `${x.toFixed(1)} ${y.toFixed(1)}`);
  }, [report, frames, whole, most]);
  const fell = report.falls_s == null ? null : onSheet(report, frames).find(({ sample }) => sample.t_s >= report.falls_s!)?.s ?? whole;
  const zero = high(0, most);
  const area = line.length > 1 ? `M${line[0]!.split(" ")[0]} ${zero}L${line.join("L")}L${line.at(-1)!.split(" ")[0]} ${zero}Z` : "";
  return (
    <div class="motions-ground" role="img" aria-label={t(report.stands ? "motions.check.stands" : "motions.check.falls")}>
      <svg viewBox="0 0 1000 100" preserveAspectRatio="none" aria-hidden="true">
        <clipPath id="motions-above"><rect width="1000" height={zero} /></clipPath>
        <clipPath id="motions-below"><rect y={zero} width="1000" height={100 - zero} /></clipPath>
        <path class="motions-ground-good" d={area} clip-path="url(#motions-above)" />
        <path class="motions-ground-bad" d={area} clip-path="url(#motions-below)" />
        <path class="motions-ground-line" d={`M0 ${zero}H1000`} />
        {line.length > 1 && <path class="motions-ground-edge" d={`M${line.join("L")}`} />}
      </svg>
      {fell !== null && <span class="motions-fell" style={{ left: `${Math.min(100, (100 * fell) / whole)}%` }} data-late={fell > 0.8 * whole || undefined}>{t("motions.check.falls.here")}</span>}
    </div>
  );
}

const high = (mm: number, most: number): number => 100 - (100 * (Math.min(most, Math.max(-BELOW * most, mm)) + BELOW * most)) / ((1 + BELOW) * most);

/** A picture of each key frame, those around the chosen one. */
function Strip({ model, frames, wrong, onChoose }: { model: BodyModel; frames: KeyFrame[]; wrong: ReadonlySet<number>; onChoose: (at: number) => void }) {
  const first = Math.max(0, Math.min(index.value - MOST_SHOWN / 2, frames.length - MOST_SHOWN));
  const shown = frames.slice(first, first + MOST_SHOWN);
  const after = frames.length - first - shown.length;
  return (
    <ol role="listbox" aria-label={t("motions.line")}>
      {first > 0 && <li class="motions-rest"><button type="button" onClick={() => onChoose(first - 1)}>+{first}</button></li>}
      {shown.map((frame, offset) => {
        const at = first + offset;
        return (
          <li key={at} ref={at === index.value ? nearby : undefined}>
            <button type="button" role="option" aria-selected={at === index.value} class="motions-frame" data-wrong={wrong.has(at) || undefined} onClick={() => onChoose(at)}>
              <Thumb model={model} frames={frames} at={at} />
              <span>{at + 1} · {number(frame.duration_s, frame.duration_s < 1 ? 2 : 1)} s</span>
            </button>
          </li>
        );
      })}
      {after > 0 && <li class="motions-rest"><button type="button" onClick={() => onChoose(first + shown.length)}>+{after}</button></li>}
    </ol>
  );
}

function nearby(item: HTMLLIElement | null): void {
  const list = item?.parentElement;
  if (!item || !list) return;
  const [left, right] = [item.offsetLeft - list.offsetLeft, item.offsetLeft - list.offsetLeft + item.offsetWidth];
  if (left < list.scrollLeft || right > list.scrollLeft + list.clientWidth) list.scrollLeft = left - list.clientWidth / 2;
}

function Thumb({ model, frames, at }: { model: BodyModel; frames: KeyFrame[]; at: number }) {
  const pose = useMemo(() => poseAt(frames, at), [frames, at]);
  return <Figure model={model} pose={pose} />;
}
