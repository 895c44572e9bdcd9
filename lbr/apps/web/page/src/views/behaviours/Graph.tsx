// A table as a picture of its states: where the robot is, and where it came from; a state that is tapped is the one whose rows are shown.
import { useEffect, useLayoutEffect, useMemo, useRef } from "preact/hooks";
import { t } from "../../words";
import type { Step } from "./data";
import { draw, HIGH, WIDE } from "./layout";

const LONGEST = 19, WAY = 26;
const short = (text: string, most: number): string => (text.length > most ? `${text.slice(0, most - 1)}…` : text);

export function Graph({ rows, at, came, picked, onPick }: { rows: Step[]; at: string; came: string; picked: string; onPick: (state: string) => void }) {
  const drawing = useMemo(() => draw(rows), [rows]);
  const box = useRef<HTMLDivElement>(null);
  const show = (state: string | undefined, behavior: ScrollBehavior): void => {
    const here = drawing.boxes.find((one) => one.state === state), view = box.current;
    if (!here || !view) return;
    const scale = view.scrollWidth / drawing.width;
    view.scrollTo({ left: here.x * scale - view.clientWidth / 2, top: here.y * scale - view.clientHeight / 2, behavior });
  };
  const first = drawing.boxes[0]?.state;
  useLayoutEffect(() => show(first, "instant"), [first]);
  useEffect(() => show(at, "smooth"), [at, drawing]);
  if (drawing.boxes.length === 0) return null;
  const size = { width: drawing.width, height: drawing.height };
  return (
    <div class="behaviours-graph" ref={box} tabIndex={0} role="group" aria-label={t("behaviours.graph")}>
      <svg viewBox={`0 0 ${size.width} ${size.height}`} {...size}>
        <defs><marker id="behaviours-tip" viewBox="0 0 10 10" refX="9" refY="5" markerWidth="7" markerHeight="7" orient="auto-start-reverse"><path class="behaviours-tip" d="M0 0 L10 5 L0 10 z" /></marker></defs>
        {drawing.ways.map((way) => {
          const taken = way.to === at && way.from === came && at !== "";
          const near = way.from === (at || picked);
          const each = way.texts.map((text) => text || t("behaviours.at.once"));
          const text = each.length > 1 ? t("behaviours.any", { count: each.length }) : way.texts[0]!;
          return (
            <g key={`${way.from}\n${way.to}`} class={`behaviours-way ${taken ? "behaviours-taken" : near ? "behaviours-near" : ""}`}>
              <path d={way.path} marker-end="url(#behaviours-tip)"><title>{each.join("\n")}</title></path>
              {near && text && <text class={way.beside ? "behaviours-beside" : ""} x={way.x} y={way.y + 4}>{short(text, WAY)}<title>{each.join("\n")}</title></text>}
            </g>
          );
        })}
        {drawing.boxes.map((one) => (
          <g
            key={one.state} class={`behaviours-state behaviours-${one.kind || "plain"} ${one.state === at ? "behaviours-at" : ""} ${one.reached ? "" : "behaviours-lost"}`}
            role="button" tabIndex={0} aria-pressed={one.state === picked} aria-label={one.state === at ? t("behaviours.here", { state: one.state }) : one.state}
            onClick={() => onPick(one.state)} onKeyDown={(event) => { if (event.key === "Enter") onPick(one.state); }}
          >
            <rect x={one.x - WIDE / 2} y={one.y - HIGH / 2} width={WIDE} height={HIGH} rx={one.kind ? HIGH / 2 : 12} />
            <text x={one.x} y={one.y + 4.5}>{short(one.state, LONGEST)}</text>
            <title>{one.state}</title>
          </g>
        ))}
      </svg>
    </div>
  );
}
