// Any number of any stream over the last minute: live, frozen, exported.
import { useEffect, useRef, useState } from "preact/hooks";
import type uPlot from "uplot";
import { listen, type Sample } from "../../live";
import { Button, Choice, Empty } from "../../parts";
import { robot, streamOfType } from "../../robot";
import { plain, tickText } from "../../format";
import { remember, remembered } from "../../kept";
import { t } from "../../words";
import { csv, numbers } from "./numbers";

const LAST_S = 60;
const DRAW_MS = 100;
const MOST_LINES = 4;
const COLOURS = ["--accent", "--warn", "--bad", "--ink"];

interface Row { s: number; values: (number | null)[] }

const FIRST = ["AttitudeState", "BatteryState", "JointsState"];
/** What is shown at first: what moves by itself, so that a chart is never empty. */
const first = (streams: string[]): string => FIRST.map(streamOfType).find((one) => streams.includes(one)) ?? streams.find((one) => one.endsWith("/state")) ?? streams[0] ?? "";
/** Numbers that are drawn at first: measured ones, not flags and dates. */
const TELLING = /(_deg|_rad|_v|_m|_mps|_rps|_percent|_c|_a)$/;

export function Chart() {
  const streams = (robot.value?.capabilities ?? []).flatMap((one) => Object.keys(one.outputs ?? {}).map((output) => `${one.name}/${output}`)).filter((key) => !key.endsWith("/frame")).sort();
  const [key, choose] = useState<string>(remembered("chart", first(streams)));
  const [fields, offer] = useState<string[]>([]);
  const [picked, pick] = useState<string[]>(remembered("chart.fields", []));
  const [frozen, freeze] = useState(false);
  const rows = useRef<Row[]>([]);
  const lines = picked.filter((one) => fields.includes(one)).slice(0, MOST_LINES);
  const heard = useRef({ lines, frozen });
  heard.current = { lines, frozen };

  useEffect(() => {
    rows.current = [];
    offer([]);
    return listen(key, (sample) => {
      const { message, at } = sample as Sample<unknown>;
      const found = numbers(message);
      offer((before) => (before.length === found.size && before.every((name) => found.has(name)) ? before : [...found.keys()]));
      if (heard.current.frozen) return;
      rows.current.push({ s: at / 1000, values: heard.current.lines.map((name) => found.get(name) ?? null) });
      while (rows.current.length > 0 && rows.current[0]!.s < at / 1000 - LAST_S) rows.current.shift();
    });
  }, [key]);
  useEffect(() => { rows.current = []; }, [lines.join()]);
  useEffect(() => {
    if (fields.length > 0 && lines.length === 0) pick([...fields.filter((one) => TELLING.test(one)), ...fields].slice(0, 2));
  }, [fields.join()]);

  const toggle = (name: string): void => {
    const next = picked.includes(name) ? picked.filter((one) => one !== name) : [...lines, name].slice(-MOST_LINES);
    pick(next);
    remember("chart.fields", next);
  };
  const save = (): void => {
    const link = document.createElement("a");
    link.href = `data:text/csv;charset=utf-8,${encodeURIComponent(csv(lines, rows.current))}`;
    link.download = `${key.replace("/", "-")}.csv`;
    link.click();
  };
  return (
    <div class="stack">
      <div class="system-tools">
        <Choice label={t("system.stream")} value={key} options={streams.map((one) => ({ value: one, text: plain(one) }))} onChange={(next) => { choose(next); remember("chart", next); }} />
        <Button icon={frozen ? "play" : "pause"} pressed={frozen} onClick={() => freeze(!frozen)}>{frozen ? t("system.run") : t("system.freeze")}</Button>
        <Button icon="save" onClick={save}>{t("system.export")}</Button>
        <Button icon="camera" onClick={() => picture(key)}>{t("system.png")}</Button>
      </div>
      {fields.length === 0 ? <Empty icon="chart" title={t("system.wait", { key: plain(key) })} /> : (
        <>
          <Plot key={`${key} ${lines.join()} ${frozen}`} names={lines} rows={rows} frozen={frozen} />
          {frozen && <p class="muted">{t("system.zoom")}</p>}
          <div class="system-fields" role="group" aria-label={t("system.field")}>
            {fields.map((name) => {
              const at = lines.indexOf(name);
              return <button key={name} type="button" class="system-field" aria-pressed={at >= 0} style={at >= 0 ? { "--tone": `var(${COLOURS[at]})` } : {}} onClick={() => toggle(name)}>{plain(name)}</button>;
            })}
          </div>
        </>
      )}
    </div>
  );
}

/** Saves the chart as it is drawn. */
function picture(key: string): void {
  const drawn = document.querySelector<HTMLCanvasElement>(".system-plot canvas");
  if (!drawn) return;
  const whole = document.createElement("canvas");
  whole.width = drawn.width;
  whole.height = drawn.height;
  const pen = whole.getContext("2d")!;
  pen.fillStyle = getComputedStyle(document.documentElement).getPropertyValue("--surface").trim() || "#fff";
  pen.fillRect(0, 0, whole.width, whole.height);
  pen.drawImage(drawn, 0, 0);
  const link = document.createElement("a");
  link.href = whole.toDataURL("image/png");
  link.download = `${key.replace("/", "-")}.png`;
  link.click();
}

function Plot({ names, rows, frozen }: { names: string[]; rows: { current: Row[] }; frozen: boolean }) {
  const place = useRef<HTMLDivElement>(null);
  useEffect(() => {
    let plot: uPlot | null = null;
    let over = false;
    const shown = place.current!;
    const sized = new ResizeObserver(() => plot?.setSize({ width: shown.clientWidth, height: shown.clientHeight }));
    void Promise.all([import("uplot"), import("uplot/dist/uPlot.min.css")]).then(([{ default: Plotter }]) => {
      if (over) return;
      const style = getComputedStyle(shown);
      const colour = (name: string): string => style.getPropertyValue(name).trim();
      const axis = { stroke: colour("--muted"), grid: { stroke: colour("--line"), width: 1 }, ticks: { stroke: colour("--line"), width: 1 }, font: "12px system-ui, sans-serif" };
      plot = new Plotter({
        width: shown.clientWidth, height: shown.clientHeight, legend: { show: false }, cursor: { drag: { x: frozen, y: false } },
        scales: { x: frozen ? { time: false } : { time: false, range: () => [-LAST_S, 0] } },
        axes: [{ ...axis, values: (_, ticks) => ticks.map((tick) => `${tick} s`) }, { ...axis, size: 64, values: (_, ticks, _axis, _space, apart) => ticks.map((tick) => tickText(tick, apart)) }],
        series: [{}, ...names.map((name, number) => ({ label: name, stroke: colour(COLOURS[number]!), width: 2, spanGaps: false, points: { show: false } }))],
      }, [[], ...names.map(() => [])], shown);
      show();
      sized.observe(shown);
    });
    const show = (): void => {
      const last = rows.current.at(-1)?.s ?? 0;
      plot?.setData([rows.current.map((row) => row.s - last), ...names.map((_, number) => rows.current.map((row) => row.values[number] ?? null))] as uPlot.AlignedData);
    };
    const draw = frozen ? undefined : setInterval(show, DRAW_MS);
    return () => {
      over = true;
      clearInterval(draw);
      sized.disconnect();
      plot?.destroy();
    };
  }, []);
  return <div class="system-plot" ref={place} role="img" aria-label={names.map(plain).join(", ")} />;
}
