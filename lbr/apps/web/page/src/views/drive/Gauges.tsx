// The numbers that a driver looks at, each with a sign when it is old.
import type { ComponentChildren } from "preact";
import { metres, number, percent } from "../../format";
import { clock, useStream, type Sample } from "../../live";
import type { BatteryState, OdometryState, Ranges, Scan } from "../../messages";
import { Icon, type IconName } from "../../parts";
import { robot, streamOfType } from "../../robot";
import { named, t } from "../../words";
import { level, nearestOf, read } from "./geometry";

interface GaugeProps { icon: IconName; label: string; value: string; unit?: string; tone?: "good" | "warn" | "bad"; sample: Sample<unknown> | null; note?: string; children?: ComponentChildren }

function Gauge({ icon, label, value, unit, tone, sample, note, children }: GaugeProps) {
  void clock.value;
  const old = sample === null || sample.stale(3000);
  return (
    <div class="drive-gauge" data-tone={old ? undefined : tone} data-old={old || undefined}>
      <span class="drive-gauge-label"><Icon name={old ? "warn" : icon} /><span>{label}</span></span>
      <span class="drive-gauge-value num">{value}{unit ? <small> {unit}</small> : null}</span>
      {note ? <span class="drive-gauge-note cut">{note}</span> : null}
      {children}
    </div>
  );
}

export function Gauges() {
  const [odometry, battery, ranges, scan] = [streamOfType("OdometryState"), streamOfType("BatteryState"), streamOfType("Ranges"), streamOfType("Scan")];
  return (
    <div class="drive-gauges">
      {odometry && <Speed from={odometry} />}
      {ranges ? <Nearest from={ranges} /> : scan && <NearestOfScan from={scan} />}
      {battery && <Battery from={battery} />}
    </div>
  );
}

function Speed({ from }: { from: string }) {
  const sample = useStream<OdometryState>(from);
  const { speed_mps, aside_mps, distance_m, slipping, stalled, reason } = sample?.message ?? {};
  const speed = aside_mps ? Math.hypot(speed_mps ?? 0, aside_mps) : speed_mps;
  return <Gauge icon="speed" label={t("drive.speed")} value={number(speed, 2)} unit="m/s" sample={sample} tone={slipping || stalled ? "warn" : undefined} note={reason || `${t("drive.way")} ${metres(distance_m)}`} />;
}

function Nearest({ from }: { from: string }) {
  const sample = useStream<Ranges>(from);
  const rows = robot.value?.ranges ?? [];
  const all = sample ? read(rows, sample.message).filter((one) => level(rows, one.name)) : [];
  const seen = all.flatMap((one) => (one.distance === null ? [] : [one.distance]));
  const blind = all.filter((one) => one.status === "invalid" || one.status === "missing");
  const nearest = seen.length > 0 ? Math.min(...seen) : null;
  const free = nearest === null && all.some((one) => one.status === "over_range");
  return (
    <Gauge
      icon={blind.length > 0 ? "warn" : "radar"} label={t("drive.nearest")} value={free ? t("drive.free") : metres(nearest)} sample={sample} tone={toneOf(nearest) ?? (blind.length > 0 ? "warn" : undefined)}
      note={blind.length > 0 ? t("drive.blind", { names: blind.map((one) => named(one.name)).join(", ") }) : ""}
    />
  );
}

function NearestOfScan({ from }: { from: string }) {
  const sample = useStream<Scan>(from);
  const nearest = sample ? nearestOf(sample.message) : null;
  return <Gauge icon="radar" label={t("drive.nearest")} value={nearest === null && sample ? t("drive.free") : metres(nearest)} sample={sample} tone={toneOf(nearest)} />;
}

const toneOf = (nearest: number | null): "bad" | "warn" | undefined => (nearest === null ? undefined : nearest < 0.4 ? "bad" : nearest < 0.9 ? "warn" : undefined);

function Battery({ from }: { from: string }) {
  const sample = useStream<BatteryState>(from);
  const { charge, voltage_v, charging, level, reason, valid } = sample?.message ?? {};
  const tone = level === "critical" ? "bad" : level === "low" ? "warn" : undefined;
  const volts = voltage_v == null ? "" : `${number(voltage_v, 1)} V`;
  return (
    <Gauge icon={charging ? "bolt" : "battery"} label={t("drive.battery")} value={charge == null ? volts || "–" : percent(charge)} sample={sample} tone={tone} note={charging ? t("drive.charging") : valid === false ? reason : charge == null ? "" : volts}>
      {charge != null && <span class="drive-gauge-bar" aria-hidden="true"><span style={{ width: `${Math.round(charge * 100)}%` }} /></span>}
    </Gauge>
  );
}
