// What the robot sees: a camera, the map, or its surroundings, behind the heading.
import { useState } from "preact/hooks";
import { useSignal } from "@preact/signals";
import { inWords } from "../../access";
import { age as ageText } from "../../format";
import { remember, remembered } from "../../kept";
import { illness } from "../../lacking";
import { clock, useStream } from "../../live";
import type { AttitudeState, CameraState, OdometryState } from "../../messages";
import { Badge, Button, Choice, Empty, Icon, Segments, type IconName } from "../../parts";
import { capabilities, command, may, streamOfType } from "../../robot";
import { call, caller, hangUp, ring } from "../../call";
import { Picture as Shown, PREFIX, usePictureAge } from "../../stream";
import { named, t } from "../../words";
import { Compass } from "./Compass";
import { MapView } from "./MapView";
import { Radar, RangesInWords } from "./Radar";

/** The state of a camera comes once a second. */
const OLD_MS = 4000;
type Picture = "camera" | "map" | "radar";

export function Stage() {
  const cameras = capabilities("camera");
  const ranges = streamOfType("Ranges") || streamOfType("Scan");
  const shown = useSignal<Picture>(remembered<Picture>("picture", "camera"));
  const choices: { value: Picture; text: string; icon: IconName }[] = [
    ...(cameras.length > 0 ? [{ value: "camera" as const, text: t("drive.camera"), icon: "camera" as const }] : []),
    ...(ranges ? [{ value: "radar" as const, text: t("drive.radar"), icon: "radar" as const }] : []),
    ...(streamOfType("OdometryState") ? [{ value: "map" as const, text: t("drive.map"), icon: "map" as const }] : []),
  ];
  const picture = choices.some((one) => one.value === shown.value) ? shown.value : choices[0]?.value;
  return (
    <section class="drive-stage" aria-label={t("drive.stage")}>
      {picture === "camera" && <Camera names={cameras.map((one) => one.name)} />}
      {picture === "map" && <MapView />}
      {picture === "radar" && <Radar reach={3} class="drive-radar-large" />}
      {picture === undefined && <Empty icon="camera" title={t("drive.camera.none")} />}
      <Heading />
      {caller() && <Phone />}
      <div class="drive-stage-choice">
        {choices.length > 1 && (
          <Segments<Picture> label={t("drive.stage")} value={picture!} options={choices} onChange={(value) => { shown.value = value; remember("picture", value); }} />
        )}
      </div>
      {ranges && picture !== "radar" && <div class="drive-inset" data-picture={picture}><Radar reach={1.7} /></div>}
      {ranges && <RangesInWords />}
    </section>
  );
}

function Phone() {
  const { stage } = call.value;
  if (stage === "idle") return may("operate") ? <Button class="drive-phone" icon="phone" label={t("call.call")} onClick={() => void ring()} /> : null;
  return <Button class="drive-phone" kind="danger" icon="hangup" label={t("call.end")} onClick={hangUp} />;
}

function Heading() {
  void clock.value;
  const attitude = useStream<AttitudeState>(streamOfType("AttitudeState"));
  const odometry = useStream<OdometryState>(attitude?.message.heading_deg == null ? streamOfType("OdometryState") : "");
  if (attitude?.message.heading_deg != null) return <Compass heading={attitude.message.heading_deg} north old={attitude.stale()} />;
  if (odometry?.message.yaw_rad != null) return <Compass heading={(-odometry.message.yaw_rad * 180) / Math.PI} north={false} old={odometry.stale()} />;
  return null;
}

function Camera({ names }: { names: string[] }) {
  const [chosen, choose] = useState<string>(remembered("camera", names[0]!));
  const name = names.includes(chosen) ? chosen : names[0]!;
  const state = useStream<CameraState>(`${name}/state`);
  const pick = (next: string): void => {
    choose(next);
    remember("camera", next);
    const chooser = capabilities("cameras")[0];
    if (chooser && may("operate")) void command(chooser.name, "select", { name: next.replace(PREFIX, "") });
  };
  const age = usePictureAge(state);
  const ill = state?.message.frames ? "" : illness(name);
  const on = state === null || state.message.on;
  return (
    <>
      {ill ? <div class="drive-nopicture" role="status"><Icon name="camera" /><p>{t("drive.camera.none")}</p></div> : on ? <Shown name={name} /> : <div class="drive-nopicture"><Icon name="camera" /><p>{t("drive.camera.off")}</p><p class="muted">{inWords(state?.message ?? {})}</p></div>}
      {names.length > 1 && (
        <div class="drive-camera">
          <Choice label={t("drive.camera")} value={name} options={names.map((one) => ({ value: one, text: named(one.replace(PREFIX, "")) }))} onChange={pick} />
        </div>
      )}
      {on && age !== null && age > OLD_MS && <div class="drive-camera-age"><Badge icon="warn" tone="warn">{t("age.stale", { age: ageText(age) })}</Badge></div>}
    </>
  );
}
