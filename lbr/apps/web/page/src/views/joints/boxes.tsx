// What stands beside the joints: how the body lies, where its power comes from, and the guard that shuts it down in time.
import { useState } from "preact/hooks";
import { inWords } from "../../access";
import { degrees, number, percent } from "../../format";
import { Badge, Button, Card, Dialog, Field, Stale, type BadgeTone } from "../../parts";
import { command, may, streamOfType } from "../../robot";
import type { AttitudeState } from "../../messages";
import { maybe, t } from "../../words";
import { ownerOf, useCalm } from "./hooks";

interface UpsState {
  valid: boolean; reason?: string; code?: string; source?: string | null; external_v?: number | null; battery_v?: number | null; output_v?: number | null; charge?: number | null;
  charging?: boolean | null; temperature_c?: number | null; relay?: boolean | null;
}
interface PowerState { phase: string; armed: boolean; warn_v: number; shutdown_v: number; reason?: string; code?: string; remaining_s?: number | null; ups?: UpsState | null }

const volts = (value: number | null | undefined): string => (value == null ? "–" : `${number(value, 2)} V`);

export function Boxes() {
  const attitude = streamOfType("AttitudeState");
  const power = streamOfType("PowerState");
  const ups = streamOfType("UpsState");
  return (
    <>
      {attitude && <Attitude stream={attitude} imu={streamOfType("ImuSample")} />}
      {ups && <Supply stream={ups} />}
      {power && <Guard stream={power} />}
    </>
  );
}

function Facts({ facts }: { facts: [string, string][] }) {
  return <dl class="joints-facts">{facts.map(([what, value]) => <div key={what}><dt>{what}</dt><dd>{value}</dd></div>)}</dl>;
}

interface ImuSample { gyro_rps?: number[] | null; accel_mps2?: number[] | null }

/** Three numbers along x, y and z. */
const along = (given: number[] | null | undefined, digits: number): string => (given?.length === 3 ? given.map((one) => number(one, digits)).join(" · ") : "–");

function Attitude({ stream, imu }: { stream: string; imu: string }) {
  const sample = useCalm<AttitudeState>(stream);
  const raw = useCalm<ImuSample>(imu, 200)?.message;
  const state = sample?.message;
  return (
    <Card title={t("joints.attitude")} icon="compass" actions={<Stale sample={sample} />}>
      <div class="joints-attitude">
        <Horizon roll={state?.valid ? state.roll_rad ?? 0 : 0} pitch={state?.valid ? state.pitch_rad ?? 0 : 0} off={!state?.valid} />
        <Facts facts={[
          [t("joints.roll"), degrees(state?.roll_rad, 1)],
          [t("joints.pitch"), degrees(state?.pitch_rad, 1)],
          [t("joints.yaw"), degrees(state?.yaw_rad, 0)],
          [t("joints.heading"), state?.heading_deg == null ? "–" : `${number(state.heading_deg)}°`],
        ]} />
      </div>
      {imu && <div class="joints-imu"><Facts facts={[[t("joints.turning"), along(raw?.gyro_rps, 2)], [t("joints.pull"), along(raw?.accel_mps2, 1)]]} /></div>}
      {state && (state.reason || state.heading_reason) && <p class="joints-reason">{inWords({ code: state.code, reason: state.reason || state.heading_reason })}</p>}
    </Card>
  );
}

/** Sky and ground as seen from the body. */
function Horizon({ roll, pitch, off }: { roll: number; pitch: number; off: boolean }) {
  const drop = Math.max(-60, Math.min(60, (pitch * 180) / Math.PI)) * 0.8;
  const rungs = [-20, -10, 10, 20];
  return (
    <svg class="joints-horizon" viewBox="-50 -50 100 100" data-off={off || undefined} role="img" aria-label={t("joints.horizon", { roll: degrees(roll), pitch: degrees(pitch) })}>
      <clipPath id="joints-horizon"><circle r="46" /></clipPath>
      <g clip-path="url(#joints-horizon)">
        <g transform={`rotate(${((-roll * 180) / Math.PI).toFixed(2)}) translate(0 ${(-drop).toFixed(2)})`}>
          <rect class="joints-sky" x="-120" y="-160" width="240" height="160" />
          <rect class="joints-ground" x="-120" y="0" width="240" height="160" />
          <path class="joints-rungs" d={`M-120 0H120${rungs.map((at) => `M${Math.abs(at) === 20 ? -14 : -9} ${-at * 0.8}h${Math.abs(at) === 20 ? 28 : 18}`).join("")}`} />
        </g>
      </g>
      <circle class="joints-bezel" r="46" />
      <path class="joints-wings" d="M-30 0h16l5 6M30 0H14l-5 6M0 -1.5a1.5 1.5 0 1 0 .01 0" />
    </svg>
  );
}

function Supply({ stream }: { stream: string }) {
  const sample = useCalm<UpsState>(stream, 500);
  const state = sample?.message;
  return (
    <Card title={t("joints.ups")} icon="battery" actions={<Stale sample={sample} after={8000} />}>
      <p class="joints-badges">
        <Badge tone={state?.source === "battery" ? "warn" : state?.valid ? "good" : "calm"} icon={state?.source === "battery" ? "battery" : "bolt"}>
          {state?.source ? maybe(`joints.source.${state.source}`) : t("joints.source.unknown")}
        </Badge>
        {state?.charging != null && <Badge>{t(state.charging ? "joints.charging" : "joints.discharging")}</Badge>}
        {state?.relay === false && <Badge tone="warn" icon="warn">{t("joints.relay.off")}</Badge>}
      </p>
      <Facts facts={[
        [t("joints.external"), volts(state?.external_v)],
        [t("joints.own"), volts(state?.battery_v)],
        [t("joints.output"), volts(state?.output_v)],
        [t("joints.temperature"), state?.temperature_c == null ? "–" : `${number(state.temperature_c)} °C`],
        ...(state?.charge == null ? [] : [[t("joints.charge"), percent(state.charge)] as [string, string]]),
      ]} />
      {state?.reason && <p class="joints-reason">{inWords(state)}</p>}
    </Card>
  );
}

const PHASE: Record<string, BadgeTone> = { watching: "good", disarmed: "calm", warning: "warn", countdown: "bad", parking: "bad", powering_off: "bad", off: "bad", failed: "bad" };

function Guard({ stream }: { stream: string }) {
  const sample = useCalm<PowerState>(stream, 200);
  const [asks, ask] = useState(false);
  const [warn, setWarn] = useState("");
  const [shutdown, setShutdown] = useState("");
  const state = sample?.message;
  if (!state) return <Card title={t("joints.guard")} icon="bolt"><p class="joints-reason">{t("age.never")}</p></Card>;
  const owner = ownerOf(stream);
  const arm = (armed: boolean): void => {
    ask(false);
    void command(owner, "arm", armed ? { armed, warn_v: Number(warn.replace(",", ".")), shutdown_v: Number(shutdown.replace(",", ".")) } : { armed });
  };
  const begin = (): void => {
    setWarn(String(state.warn_v));
    setShutdown(String(state.shutdown_v));
    ask(true);
  };
  const counting = state.phase === "countdown" && state.remaining_s != null;
  return (
    <Card title={t("joints.guard")} icon="bolt">
      <p class="joints-badges">
        <Badge tone={PHASE[state.phase] ?? "calm"} icon={PHASE[state.phase] === "bad" ? "warn" : state.armed ? "check" : "info"}>{maybe(`joints.phase.${state.phase}`) || state.phase}</Badge>
        {counting && <strong class="joints-countdown" role="timer">{number(state.remaining_s)} s</strong>}
      </p>
      <Facts facts={[[t("joints.warn_v"), volts(state.warn_v)], [t("joints.shutdown_v"), volts(state.shutdown_v)]]} />
      {state.code && <p class="joints-reason">{inWords(state)}</p>}
      <div class="joints-actions">
        {counting && <Button kind="primary" disabled={!may("operate")} onClick={() => void command(owner, "cancel", { reason: "from the page" })}>{t("joints.cancel")}</Button>}
        {state.armed
          ? <Button disabled={!may("admin")} onClick={() => arm(false)}>{t("joints.disarm")}</Button>
          : <Button disabled={!may("admin")} onClick={begin}>{t("joints.arm")}</Button>}
      </div>
      <Dialog
        title={t("joints.arm.title")} open={asks} onClose={() => ask(false)}
        actions={<><Button kind="quiet" onClick={() => ask(false)}>{t("dialog.cancel")}</Button><Button kind="primary" onClick={() => arm(true)}>{t("joints.arm")}</Button></>}
      >
        <p>{t("joints.arm.text")}</p>
        <div class="joints-volts">
          <Field label={t("joints.warn_v")} inputMode="decimal" value={warn} onInput={(event) => setWarn(event.currentTarget.value)} />
          <Field label={t("joints.shutdown_v")} inputMode="decimal" value={shutdown} onInput={(event) => setShutdown(event.currentTarget.value)} />
        </div>
      </Dialog>
    </Card>
  );
}
