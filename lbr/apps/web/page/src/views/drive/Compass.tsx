// The heading as a tape, as pilots read it: where the robot looks is in the middle.
import { between, heading as within, number, wind } from "../../format";
import { t } from "../../words";

const SPAN_DEG = 130;
const WIDTH = 390;
const MARKS = Array.from({ length: 24 }, (_, mark) => mark * 15);

/** `north`: by a compass; otherwise relative to where the robot began. */
export function Compass({ heading, north, old }: { heading: number; north: boolean; old: boolean }) {
  const here = within(heading);
  const scale = WIDTH / SPAN_DEG;
  return (
    <div class="drive-compass" data-old={old || undefined} role="img" aria-label={t("drive.compass.alt", { heading: Math.round(here) % 360 })}>
      <svg viewBox={`${-WIDTH / 2} 0 ${WIDTH} 44`} aria-hidden="true">
        {MARKS.map((mark) => {
          const x = between(here, mark) * scale;
          if (Math.abs(x) > WIDTH / 2 + 12) return null;
          const named = mark % 45 === 0;
          const fade = 1 - (Math.abs(x) / (WIDTH / 2)) ** 2 * 0.85;
          return (
            <g key={mark} style={{ transform: `translateX(${x}px)`, opacity: fade }}>
              <path d={named ? "M0 6v7" : "M0 9v4"} />
              {named && <text y="29" class={north && mark % 90 === 0 ? "drive-compass-wind" : ""}>{north ? wind(mark) : mark}</text>}
            </g>
          );
        })}
        <path class="drive-compass-here" d="M-5 0h10L0 6z" />
      </svg>
      <output class="num" aria-hidden="true">{number(Math.round(here) % 360)}°</output>
    </div>
  );
}
