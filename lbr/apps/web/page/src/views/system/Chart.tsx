// Any number of any stream over the last minute: live, frozen, exported.
import { useEffect, useRef, useState } from "preact/hooks";
import type uPlot from "uplot";
import { listen, type Sample } from "../../live";
import { Button, Choice, Empty } from "../../parts";
import { robot } from "../../robot";
import { plain } from "../../format";
import { remember, remembered } from "../../kept";
import { t } from "../../words";
import { csv, numbers } from "./numbers";

const LAST_S = 60;
const DRAW_MS = 100;
const MOST_LINES = 4;
const COLOURS = ["--accent", "--warn", "--bad", "--ink"];

interface Row { s: number; values: (number | null)[] }

export function Chart() {
  const streams = (robot.value?.capabilities ?? []).flatMap((one) => Object.keys(one.outputs ?? {}).map((output) => `${one.name}/${output}`)).filter((key) => !key.endsWith("/frame")).sort();
  const [key, choose] = useState<string>(remembered("chart", streams.find((one) => one.startsWith("odometry/")) ?? streams[0] ?? ""));
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
    if (fields.length > 0 && lines.length === 0) pick(fields.slice(0, 2));
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
      </div>
      {fields.length === 0 ? <Empty icon="chart" title={t("system.wait", { key: plain(key) })} /> : (
        <>
          <Plot key={`${key} ${lines.join()}`} names={lines} rows={rows} />
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

function Plot({ names, rows }: { names: string[]; rows: { current: Row[] } }) {
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
        width: shown.clientWidth, height: shown.clientHeight, legend: { show: false }, cursor: { drag: { x: false, y: false } },
        scales: { x: { time: false, range: () => [-LAST_S, 0] } },
        axes: [{ ...axis, values: (_, ticks) => ticks.map((tick) => `${tick} s`) }, { ...axis, size: 64 }],
        series: [{}, ...names.map((name, number) => ({ label: name, stroke: colour(COLOURS[number]!), width: 2, spanGaps: false, points: { show: false } }))],
      }, [[], ...names.map(() => [])], shown);
      sized.observe(shown);
    });
    const draw = setInterval(() => {
      const last = rows.current.at(-1)?.s ?? 0;
      plot?.setData([rows.current.map((row) => row.s - last), ...names.map((_, number) => rows.current.map((row) => row.values[number] ?? null))] as uPlot.AlignedData);
    }, DRAW_MS);
    return () => {
      over = true;
      clearInterval(draw);
      sized.disconnect();
      plot?.destroy();
    };
  }, []);
  return <div class="system-plot" ref={place} role="img" aria-label={names.map(plain).join(", ")} />;
}
