// Moves that end by themselves, by values that are chosen: go, turn, face a heading; and the dock.
import { signal } from "@preact/signals";
import { number, wind } from "../../format";
import { holding } from "../../holding";
import { remember, remembered } from "../../kept";
import { notice } from "../../notices";
import { Button, Card, Icon, type IconName } from "../../parts";
import { consoleLine, knows, may, robot } from "../../robot";
import { t } from "../../words";
import { top } from "./pilot";
import { Value, within, type Bounds } from "./Value";

const WINDS_DEG = [0, 90, 180, 270];
const GO: Bounds = { least: 5, most: 1000, steps: [5, 10, 20, 30, 50, 75, 100, 150, 200, 300, 500, 1000], digits: 0 };
const TURN: Bounds = { least: 1, most: 360, steps: [5, 10, 15, 30, 45, 60, 90, 120, 180, 270, 360], digits: 0 };
const FACE: Bounds = { least: 0, most: 359, steps: [0, 45, 90, 135, 180, 225, 270, 315], digits: 0, round: true };
const kept = (name: string, otherwise: number, bounds: Bounds) => signal<number>(within(remembered(name, otherwise), bounds, otherwise));
const [distance, angle, heading] = [kept("go", 50, GO), kept("turn", 90, TURN), kept("face", 0, FACE)];

function Move({ icon, label, onClick }: { icon: IconName; label: string; onClick: () => void }) {
  return <button type="button" class="drive-move" aria-label={label} title={label} disabled={!may("operate")} onClick={onClick}><Icon name={icon} /></button>;
}

export function Moves({ drive }: { drive: string }) {
  const has = (name: string): boolean => robot.value?.capabilities.find((one) => one.name === drive)?.commands[name] !== undefined;
  const turn = (angle_deg: number): void => holding.play(`${drive}/turn`, { angle_deg });
  const go = (distance_cm: number, angle_deg: number): void => holding.play(`${drive}/command`, { power: Math.max(0.1, top.value), angle_deg, distance_cm });
  const face = (heading_deg: number): void => holding.play(`${drive}/heading`, { heading_deg });
  const dock = async (): Promise<void> => {
    const answer = await consoleLine("autodock");
    if (answer.ok) notice(t("drive.docking"), "info");
  };
  const change = (name: string, to: typeof distance) => (value: number): void => { to.value = value; remember(name, value); };
  return (
    <Card title={t("drive.steps")} icon="turn" class="drive-moves">
      <div class="drive-move-row">
        <Move icon="back" label={t("drive.backwards", { to: distance.value })} onClick={() => go(distance.value, 180)} />
        <Value label={t("drive.distance")} unit="cm" bounds={GO} value={distance.value} onChange={change("go", distance)} />
        <Move icon="ahead" label={t("drive.ahead", { to: distance.value })} onClick={() => go(distance.value, 0)} />
      </div>
      {has("turn") && (
        <div class="drive-move-row">
          <Move icon="turnleft" label={t("drive.turn.go", { to: -angle.value })} onClick={() => turn(-angle.value)} />
          <Value label={t("drive.angle")} unit="°" bounds={TURN} value={angle.value} onChange={change("turn", angle)} />
          <Move icon="turn" label={t("drive.turn.go", { to: angle.value })} onClick={() => turn(angle.value)} />
        </div>
      )}
      {has("heading") && (
        <div class="drive-face" role="group" aria-label={t("drive.face")}>
          <div class="drive-winds">
            {WINDS_DEG.map((heading_deg) => (
              <Button key={heading_deg} disabled={!may("operate")} label={t("drive.face.go", { to: wind(heading_deg) })} onClick={() => { change("face", heading)(heading_deg); face(heading_deg); }}>{wind(heading_deg)}</Button>
            ))}
          </div>
          <div class="drive-move-row">
            <Value label={t("drive.heading")} unit="°" bounds={FACE} value={heading.value} onChange={change("face", heading)} />
            <Move icon="compass" label={t("drive.face.go", { to: `${number(heading.value)}°` })} onClick={() => face(heading.value)} />
          </div>
        </div>
      )}
      {knows("autodock") && <Button icon="dock" disabled={!may("operate")} onClick={() => void dock()}>{t("drive.dock")}</Button>}
    </Card>
  );
}
