// The numbers that a driver looks at, each with a sign when it is old.
import type { ComponentChildren } from "preact";
import { metres, number, percent } from "../../format";
import { clock, useStream, type Sample } from "../../live";
import type { BatteryState, OdometryState, Ranges } from "../../messages";
import { Icon, type IconName } from "../../parts";
import { robot, streamOfType } from "../../robot";
import { t } from "../../words";
import { fans } from "./geometry";

interface GaugeProps { icon: IconName; label: string; value: string; unit?: string; tone?: "good" | "warn" | "bad"; sample: Sample<unknown> | null; note?: string; children?: ComponentChildren }

function Gauge({ icon, label, value, unit, tone, sample, note, children }: GaugeProps) {
  void clock.value;
  const old = sample === null || sample.stale(3000);
  return (
    <div class="drive-gauge" data-tone={old ? undefined : tone} data-old={old || undefined}>
      <span class="drive-gauge-label"><Icon name={old ? "warn" : icon} />{label}</span>
      <span class="drive-gauge-value num">{value}{unit && <small> {unit}</small>}</span>
      {note && <span class="drive-gauge-note cut">{note}</span>}
      {children}
    </div>
  );
}

export function Gauges() {
  const [odometry, battery, ranges] = [streamOfType("OdometryState"), streamOfType("BatteryState"), streamOfType("Ranges")];
  return (
    <div class="drive-gauges">
      {odometry && <Speed from={odometry} />}
      {ranges && <Nearest from={ranges} />}
      {battery && <Battery from={battery} />}
    </div>
  );
}

function Speed({ from }: { from: string }) {
  const sample = useStream<OdometryState>(from);
  const { speed_mps, distance_m, slipping, stalled, reason } = sample?.message ?? {};
  return <Gauge icon="speed" label={t("drive.speed")} value={number(speed_mps, 2)} unit="m/s" sample={sample} tone={slipping || stalled ? "warn" : undefined} note={reason || `${t("drive.way")} ${metres(distance_m)}`} />;
}

function Nearest({ from }: { from: string }) {
  const sample = useStream<Ranges>(from);
  const seen = sample ? fans(robot.value?.ranges ?? [], sample.message).flatMap((fan) => (fan.distance === null ? [] : [fan.distance])) : [];
  const nearest = seen.length > 0 ? Math.min(...seen) : null;
  const tone = nearest === null ? undefined : nearest < 0.4 ? "bad" : nearest < 0.9 ? "warn" : undefined;
  return <Gauge icon="radar" label={t("drive.nearest")} value={nearest === null && sample ? "> 3 m" : metres(nearest)} sample={sample} tone={tone} />;
}

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
