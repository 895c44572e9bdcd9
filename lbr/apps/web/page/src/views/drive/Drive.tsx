// Drive: the robot's eyes, the stick, and why it does not move.
import type { ComponentType } from "preact";
import { useEffect, useState } from "preact/hooks";
import { Slider, Toggle } from "../../parts";
import { number, percent } from "../../format";
import { may, robot, streamOfType } from "../../robot";
import { t } from "../../words";
import { Gauges } from "./Gauges";
import { gather } from "./MapView";
import { base, listenToHands, sideways, top } from "./pilot";
import { Stage } from "./Stage";
import { Stick } from "./Stick";
import { canTilt, tilt, tilts } from "./tilt";
import { Turner } from "./Turner";
import { Why } from "./Why";
import "./Drive.css";

export default function Drive() {
  const from = streamOfType("DriveState");
  const drive = from.split("/")[0]!;
  useEffect(() => listenToHands(drive), [drive]);
  useEffect(gather, [robot.value?.revision]);
  useEffect(keepAwake, []);
  const [below, show] = useState<{ Shown?: ComponentType<{ drive: string }> }>({});
  useEffect(() => { import("./Below").then((module) => show({ Shown: module.default }), () => undefined); }, []);
  return (
    <div class="drive">
      <h2 class="sr">{t("view.drive")}</h2>
      <div class="drive-first">
        <Stage />
        <Why from={from} />
        <div class="drive-hands">
          <Gauges />
          <div class="drive-hand">
            <Stick />
            {sideways() && <Turner />}
            <Slider label={t("drive.power")} min={0.1} max={1} step={0.05} value={top.value} show={speed} disabled={!may("operate")} onInput={(value) => { top.value = value; }} />
            {canTilt() && <Toggle label={t("drive.tilt")} checked={tilts.value} disabled={!may("operate")} onChange={(on) => void tilt(on)} />}
          </div>
        </div>
      </div>
      <div class="drive-more">
        {below.Shown && <below.Shown drive={drive} />}
      </div>
    </div>
  );
}

/** A share of what the settings allow, as the speed that it is. */
function speed(share: number): string {
  const most = base()?.max_speed_mps;
  return most ? `${number(share * most, 2)} m/s` : percent(share);
}

/** Has the screen stay on while one drives, where the browser can. */
function keepAwake(): () => void {
  let lock: WakeLockSentinel | undefined;
  const keep = (): void => {
    if (!document.hidden) navigator.wakeLock?.request("screen").then((one) => { lock = one; }, () => undefined);
  };
  keep();
  document.addEventListener("visibilitychange", keep);
  return () => {
    document.removeEventListener("visibilitychange", keep);
    void lock?.release();
  };
}
