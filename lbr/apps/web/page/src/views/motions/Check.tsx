// What the check of balance says: stands or falls, when, and the floor under the feet at the moment that is looked at.
import { number } from "../../format";
import { Badge, Button, Card, Icon } from "../../parts";
import { may } from "../../robot";
import { t } from "../../words";
import { busy, cancel, checking, current, type Report, type Sample, type Spot } from "./balance";

export function CheckCard({ sample, empty, onCheck }: { sample: Sample | null; empty: boolean; onCheck: () => void }) {
  const known = current.value;
  const report = known?.report ?? null;
  return (
    <Card title={t("motions.check")} icon="balance" class="motions-check" actions={busy.value ? <Button kind="quiet" icon="close" label={t("motions.check.cancel")} onClick={cancel} /> : undefined}>
      {busy.value
        ? <div class="motions-checking" role="progressbar" aria-valuemin={0} aria-valuemax={100} aria-valuenow={Math.round(100 * checking.value.part)} aria-label={t("motions.check.busy")}><span style={{ width: `${100 * checking.value.part}%` }} /></div>
        : report ? <Verdict report={report} /> : known?.why ? <p class="motions-why"><Icon name="info" />{known.why}</p> : <p class="motions-hint">{t("motions.check.text")}</p>}
      {report && <Floor report={report} sample={sample ?? worst(report)} />}
      {!busy.value && <div class="joints-actions"><Button icon="balance" disabled={empty || !may("operate")} onClick={onCheck}>{t(report ? "motions.check.again" : "motions.check.do")}</Button></div>}
    </Card>
  );
}

function Verdict({ report }: { report: Report }) {
  const facts = [
    report.least_mm == null || !report.stands ? "" : t("motions.check.least", { mm: number(report.least_mm), s: number(report.least_s ?? 0, 1) }),
    report.led && report.begins ? t("motions.check.led") : "",
    t("motions.check.took", { s: number(report.duration_s, 1), took: number(report.took_s, 1) }),
  ].filter(Boolean);
  return (
    <div class="motions-verdict" role="status">
      {report.stands
        ? <Badge tone="good" icon="check">{t("motions.check.stands")}</Badge>
        : report.falls_s != null
          ? <Badge tone="bad" icon="warn">{t("motions.check.falls.at", { s: number(report.falls_s, 1), frame: report.falls_frame ?? 0 })}</Badge>
          : <Badge tone="warn" icon="warn">{t("motions.check.begins")}</Badge>}
      <p>{facts.join(" · ")}</p>
    </div>
  );
}

/** The sample at which it came nearest to falling, or began to tip over. */
function worst(report: Report): Sample | null {
  const before = upright(report).filter((one) => one.margin_mm != null);
  if (report.falls_s != null) return before.find((one, at) => one.margin_mm! < 0 && before.slice(at).every((later) => later.margin_mm! < 0)) ?? before.at(-1) ?? null;
  return before.reduce<Sample | null>((least, one) => (least === null || one.margin_mm! < least.margin_mm! ? one : least), null);
}

/** What was before it fell. */
const upright = (report: Report): Sample[] => report.trace.filter((one) => report.falls_s == null || one.t_s <= report.falls_s);

/** The floor from above, the robot looking up: what carries it, its centre of mass, the middle of what presses. */
function Floor({ report, sample }: { report: Report; sample: Sample | null }) {
  const all = upright(report).flatMap((one) => [one.mass, ...one.support]);
  const reach = Math.min(400, Math.max(60, ...all.map(([x, y]) => Math.max(Math.abs(x), Math.abs(y))))) * 1.12;
  const dot = reach / 24;
  const out = sample?.margin_mm != null && sample.margin_mm < 0;
  const path = upright(report).filter((one) => one.t_s <= (sample?.t_s ?? Infinity)).map((one) => place(one.mass).join(" "));
  return (
    <figure class="motions-floor">
      <svg viewBox={`${-reach * 1.5} ${-reach} ${3 * reach} ${2 * reach}`} role="img" aria-label={sample?.margin_mm == null ? t("motions.check.air") : t("motions.check.margin", { mm: number(sample.margin_mm) })}>
        <path class="motions-floor-grid" d={`M0 ${-reach}V${reach}M${-1.5 * reach} 0H${1.5 * reach}`} stroke-width={reach / 160} />
        {sample && sample.support.length > 1 && <polygon class="motions-floor-support" data-out={out || undefined} points={sample.support.map((one) => place(one).join(",")).join(" ")} stroke-width={reach / 60} />}
        {path.length > 1 && <path class="motions-floor-path" d={`M${path.join("L")}`} stroke-width={reach / 90} />}
        {sample?.pressure && <circle class="motions-floor-pressure" cx={place(sample.pressure)[0]} cy={place(sample.pressure)[1]} r={dot * 1.25} stroke-width={reach / 60} />}
        {sample && <circle class="motions-floor-mass" data-out={out || undefined} cx={place(sample.mass)[0]} cy={place(sample.mass)[1]} r={dot} />}
      </svg>
      <figcaption>
        <span data-key="mass">{t("motions.check.mass")}</span><span data-key="pressure">{t("motions.check.pressure")}</span><span data-key="support">{t("motions.check.support")}</span>
      </figcaption>
    </figure>
  );
}

/** Ahead is up, left is left. */
const place = ([ahead, left]: Spot): Spot => [-left, -ahead];
