// What was: battery, speed, distances and temperatures over minutes, hours or a day, what happened then, and why it stood.
import { useEffect, useMemo, useRef, useState } from "preact/hooks";
import type uPlot from "uplot";
import { told } from "../../access";
import { number, plain, tickText } from "../../format";
import { remember, remembered } from "../../kept";
import { events, link } from "../../live";
import type { Event } from "../../messages";
import { Button, Empty, Icon, Segments } from "../../parts";
import { fetchJson, robot } from "../../robot";
import { save as hand } from "../../saving";
import { maybe, t } from "../../words";
import { merged } from "./listing";
import { box, drawn, history, joined, quantities, table, explained, type Past, type Quantity, type Then } from "./past";

const SPANS = ["10m", "1h", "6h", "24h"] as const;
type Span = (typeof SPANS)[number];
const MINUTES: Record<Span, number> = { "10m": 10, "1h": 60, "6h": 360, "24h": 1440 };
const POINTS = 240;
const LEAST_AGAIN_MS = 5000;
/** A robot that has just started has nothing to show for a moment. */
const FIRST_AGAIN_MS = 2000;
const NONE: Past = { at_ms: [], values: {} };
const MARKS = 300;

export function History() {
  const [span, choose] = useState<Span>(remembered<Span>("history", "1h"));
  const [past, setPast] = useState<Past>(NONE);
  const [looked, look] = useState(false);
  const [why, refuse] = useState("");
  const [at, stand] = useState<number | null>(null);
  const [zoom, setZoom] = useState<[number, number] | null>(null);
  const all = useMemo(quantities, [robot.value?.revision]);
  const fields = all.flatMap((one) => one.fields);
  const wide = MINUTES[span] * 60_000;
  const there = link.value === "open";
  const from = zoom?.[0] ?? 0, to = zoom?.[1] ?? 0;
  useEffect(() => {
    if (!there || !box() || fields.length === 0) return undefined;
    let over = false, timer: ReturnType<typeof setTimeout> | undefined;
    let known = NONE;
    const step = (zoom ? to - from : wide) / POINTS;
    const ask = async (): Promise<void> => {
      const now = Date.now();
      const begin = zoom ? from : Math.max(now - wide, (known.at_ms.at(-1) ?? 0) + 1);
      const end = zoom ? to : now;
      const answer = await history(fields, begin, end, Math.max(2, Math.min(POINTS, Math.round((end - begin) / step))));
      if (over) return;
      look(true);
      refuse(answer.ok ? "" : told(answer));
      if (answer.ok && answer.data) setPast(known = joined(known, answer.data, zoom ? from : now - wide));
      if (!zoom) timer = setTimeout(() => void ask(), known.at_ms.length > 1 ? Math.max(step, LEAST_AGAIN_MS) : FIRST_AGAIN_MS);
    };
    void ask();
    return () => { over = true; clearTimeout(timer); };
  }, [span, fields.join(), there, from, to]);
  const happened = useHappened(there);
  if (!box()) return <Empty icon="chart" title={t("past.none")}><p>{t("past.none.text")}</p></Empty>;
  const shown = all.map((one) => ({ of: one, values: drawn(one, past) })).filter(({ values }) => values.some((value) => value !== null));
  const first = past.at_ms[0] ?? 0;
  const marks = happened.filter((one) => (one.wall_ns ?? 0) / 1e6 >= first);
  return (
    <div class="stack">
      <div class="system-tools">
        <Segments<Span> label={t("past.span")} value={span} onChange={(next) => { choose(next); remember("history", next); setZoom(null); setPast(NONE); look(false); }} options={SPANS.map((value) => ({ value, text: t(`past.${value}`) }))} />
        <Button icon="save" disabled={shown.length === 0} onClick={() => hand("history.csv", new TextEncoder().encode(table(shown.map((one) => one.of), past)))}>{t("system.export")}</Button>
        {zoom && <Button icon="fit" onClick={() => setZoom(null)}>{t("past.all")}</Button>}
      </div>
      {why && <p class="system-problem">{why}</p>}
      {shown.length === 0 ? <Empty icon="chart" title={t(looked ? "past.empty" : "rows.wait")} /> : (
        <>
          <p class="muted past-hint">{t("past.hint")}</p>
          <div class="past-charts">
            {shown.map(({ of, values }) => <Plot key={`${of.key} ${zoom ? `${from} ${to}` : span}`} of={of} at={past.at_ms} values={values} marks={marks} chosen={at} onPick={stand} onZoom={(a, b) => setZoom([a, b])} />)}
          </div>
        </>
      )}
      {at !== null && <Moment key={at} at={at} events={happened} onClose={() => stand(null)} />}
    </div>
  );
}

/** Warnings and errors that were written down, and those since. */
function useHappened(there: boolean): Event[] {
  const [written, tell] = useState<Event[]>([]);
  useEffect(() => {
    if (!there) return;
    void fetchJson<{ data: { events: Event[] } | null }>("api/events?level=warning", { quiet: true, timeoutMs: 12_000 }).then((answer) => tell(answer.data?.data?.events ?? []));
  }, [there]);
  const heard = events.value;
  return useMemo(() => merged(heard.filter((one) => (one.level ?? "info") !== "info"), written, MARKS).map((one) => one.event), [heard, written]);
}

const clockOf = (ms: number): string => new Date(ms).toLocaleString(document.documentElement.lang || "en", { weekday: "short", hour: "2-digit", minute: "2-digit", second: "2-digit", hourCycle: "h23" });

const timeAt = (ms: number, seconds: boolean): string => new Date(ms).toLocaleTimeString(document.documentElement.lang || "en", { hour: "2-digit", minute: "2-digit", ...(seconds ? { second: "2-digit" } : {}), hourCycle: "h23" });

/** Why the robot stood, or did not, at a moment, and what happened about then. */
function Moment({ at, events: all, onClose }: { at: number; events: Event[]; onClose: () => void }) {
  const [answer, tell] = useState<Then | null>(null);
  const [refused, refuse] = useState(false);
  useEffect(() => void explained(at).then((one) => { if (one.ok) tell(one.data); else refuse(true); }), []);
  const near = all.filter((one) => Math.abs((one.wall_ns ?? 0) / 1e6 - at) < 60_000).slice(0, 5);
  return (
    <section class="past-moment" aria-label={t("past.moment", { when: clockOf(at) })} role="status">
      <div class="card-head"><Icon name="info" /><h3>{clockOf(at)}</h3><div class="card-actions"><Button kind="quiet" icon="close" label={t("dialog.close")} onClick={onClose} /></div></div>
      {answer ? (
        <p><strong>{answer.state === "ok" ? t("drive.why.nothing") : maybe(`code.${answer.code}`) || t("drive.why")}</strong> {answer.state !== "ok" && <span lang="en">{answer.text}</span>}</p>
      ) : <p class="muted">{t(refused ? "past.unknown" : "rows.wait")}</p>}
      {answer && answer.late_s > 3 && <p class="muted">{t("past.late", { s: number(answer.late_s) })}</p>}
      {near.map((one) => <p key={`${one.wall_ns}${one.text}`} class="muted"><span class="num">{clockOf((one.wall_ns ?? 0) / 1e6)}</span> <strong>{plain(one.subject)}</strong> <span lang="en">{one.text}</span></p>)}
    </section>
  );
}

function Plot({ of, at, values, marks, chosen, onPick, onZoom }: { of: Quantity; at: number[]; values: (number | null)[]; marks: Event[]; chosen: number | null; onPick: (ms: number) => void; onZoom: (fromMs: number, toMs: number) => void }) {
  const place = useRef<HTMLDivElement>(null);
  const plot = useRef<uPlot | null>(null);
  const [under, point] = useState<number | null>(null);
  const now = useRef({ marks, chosen, onPick, onZoom });
  now.current = { marks, chosen, onPick, onZoom };
  const data = (): uPlot.AlignedData => [at.map((ms) => ms / 1000), values];
  useEffect(() => {
    let over = false;
    const shown = place.current!;
    const sized = new ResizeObserver(() => plot.current?.setSize({ width: shown.clientWidth, height: shown.clientHeight }));
    void Promise.all([import("uplot"), import("uplot/dist/uPlot.min.css")]).then(([{ default: Plotter }]) => {
      if (over) return;
      const style = getComputedStyle(shown);
      const colour = (name: string): string => style.getPropertyValue(name).trim();
      const axis = { stroke: colour("--muted"), grid: { stroke: colour("--line"), width: 1 }, ticks: { stroke: colour("--line"), width: 1 }, font: "12px system-ui, sans-serif" };
      const lines = (drawing: uPlot): void => {
        const { ctx, bbox } = drawing;
        const line = (ms: number, tone: string): void => {
          const x = drawing.valToPos(ms / 1000, "x", true);
          if (x < bbox.left || x > bbox.left + bbox.width) return;
          ctx.strokeStyle = tone;
          ctx.lineWidth = 1.5 * devicePixelRatio;
          ctx.beginPath();
          ctx.moveTo(x, bbox.top);
          ctx.lineTo(x, bbox.top + bbox.height);
          ctx.stroke();
        };
        for (const one of now.current.marks) line((one.wall_ns ?? 0) / 1e6, colour(one.level === "error" ? "--bad" : "--warn"));
        if (now.current.chosen !== null) line(now.current.chosen, colour("--ink"));
      };
      plot.current = new Plotter({
        width: shown.clientWidth, height: shown.clientHeight, legend: { show: false },
        cursor: { sync: { key: "past" }, drag: { x: true, y: false, setScale: false, dist: 8 } },
        scales: { y: { range: (_, low, high) => (low === high ? [low - 0.5, high + 0.5] : [low - (high - low) * 0.08, high + (high - low) * 0.08]) } },
        axes: [{ ...axis, size: 34, space: 70, values: (_, ticks, _axis, _space, apart) => ticks.map((tick) => timeAt(tick * 1000, apart < 60)) }, { ...axis, size: 56, values: (_, ticks, _axis, _space, apart) => ticks.map((tick) => tickText(tick, apart)) }],
        series: [{}, { stroke: colour(of.colour), width: 2, spanGaps: false, points: { show: false } }],
        hooks: {
          draw: [lines],
          setCursor: [(drawing) => point(drawing.cursor.idx ?? null)],
          setSelect: [(drawing) => {
            const { left, width } = drawing.select;
            if (width < 8) return;
            now.current.onZoom(drawing.posToVal(left, "x") * 1000, drawing.posToVal(left + width, "x") * 1000);
          }],
        },
      }, data(), shown);
      plot.current.over.addEventListener("click", () => {
        const seconds = plot.current?.data[0]?.[plot.current.cursor.idx ?? -1];
        if (seconds !== undefined) now.current.onPick(seconds * 1000);
      });
      sized.observe(shown);
    });
    return () => {
      over = true;
      sized.disconnect();
      plot.current?.destroy();
      plot.current = null;
    };
  }, []);
  useEffect(() => plot.current?.setData(data()), [at, values.length]);
  useEffect(() => plot.current?.redraw(false), [marks.length, chosen]);
  const last = values.reduce<number>((found, value, place) => (value === null ? found : place), -1);
  const read = under !== null && at[under] !== undefined ? under : last;
  return (
    <figure class="past-chart">
      <figcaption><span>{t(of.word)}</span><strong class="num">{number(values[read], of.digits)} {of.unit}</strong><span class="muted num">{read === under ? clockOf(at[read]!) : ""}</span></figcaption>
      <div class="past-plot" ref={place} role="img" aria-label={t("past.chart", { what: t(of.word), value: number(values[last], of.digits), unit: of.unit })} />
    </figure>
  );
}
