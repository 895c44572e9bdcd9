// Moves that end by themselves: turn, go, face a wind, dock.
import { holding } from "../../holding";
import { Button, Card, Icon, type IconName } from "../../parts";
import { consoleLine, knows, may, robot } from "../../robot";
import { notice } from "../../notices";
import { t } from "../../words";
import { top } from "./pilot";

const WINDS = [["N", 0], ["E", 90], ["S", 180], ["W", 270]] as const;

function Move({ icon, text, label, onClick }: { icon: IconName; text: string; label: string; onClick: () => void }) {
  return <button type="button" class="drive-move" aria-label={label} title={label} disabled={!may("operate")} onClick={onClick}><Icon name={icon} /><span class="num">{text}</span></button>;
}

export function Moves({ drive }: { drive: string }) {
  const has = (name: string): boolean => robot.value?.capabilities.find((one) => one.name === drive)?.commands[name] !== undefined;
  const turn = (angle_deg: number): void => holding.play(`${drive}/turn`, { angle_deg });
  const go = (distance_cm: number, angle_deg: number): void => holding.play(`${drive}/command`, { power: Math.max(0.1, top.value), angle_deg, distance_cm });
  const dock = async (): Promise<void> => {
    const answer = await consoleLine("autodock");
    if (answer.ok) notice(t("drive.docking"), "info");
  };
  return (
    <Card title={t("drive.steps")} icon="turn" class="drive-moves">
      <div class="drive-move-grid">
        {has("turn") && <Move icon="turnleft" text="90°" label={t("drive.turn.go", { to: -90 })} onClick={() => turn(-90)} />}
        <Move icon="ahead" text="50 cm" label={t("drive.ahead", { to: 50 })} onClick={() => go(50, 0)} />
        {has("turn") && <Move icon="turn" text="90°" label={t("drive.turn.go", { to: 90 })} onClick={() => turn(90)} />}
        {has("turn") && <Move icon="turnleft" text="15°" label={t("drive.turn.go", { to: -15 })} onClick={() => turn(-15)} />}
        <Move icon="back" text="50 cm" label={t("drive.backwards", { to: 50 })} onClick={() => go(50, 180)} />
        {has("turn") && <Move icon="turn" text="15°" label={t("drive.turn.go", { to: 15 })} onClick={() => turn(15)} />}
      </div>
      {has("heading") && (
        <div class="drive-winds" role="group" aria-label={t("drive.face")}>
          <span class="field-label"><Icon name="compass" />{t("drive.face")}</span>
          {WINDS.map(([name, heading_deg]) => (
            <Button key={name} disabled={!may("operate")} label={t("drive.face.go", { to: name })} onClick={() => holding.play(`${drive}/heading`, { heading_deg })}>{name}</Button>
          ))}
        </div>
      )}
      {knows("autodock") && <Button icon="dock" disabled={!may("operate")} onClick={() => void dock()}>{t("drive.dock")}</Button>}
    </Card>
  );
}
