// Posing by hand: joints without torque are put where they are to be, and the robot's own pose becomes a key frame.
import { useState } from "preact/hooks";
import { Button, Card, Dialog, Segments, Toggle } from "../../parts";
import { command, may } from "../../robot";
import { t } from "../../words";
import type { Joints } from "../joints/hooks";
import { jointNames, type BodyModel, type Side } from "../joints/model";
import { torques } from "../joints/tone";

const SIDES = ["left", "right", "all"] as const;
type Which = (typeof SIDES)[number];

export function Hands({ model, joints, live, onLive, onCapture }: { model: BodyModel; joints: Joints | null; live: boolean; onLive: (on: boolean) => void; onCapture: () => void }) {
  const [which, choose] = useState<Which>("left");
  const [asks, ask] = useState(false);
  const names = jointNames(model).filter((name) => which === "all" || model.joints[name]?.side === (which as Side));
  const { held, limp } = torques(names, joints?.state.joints);
  const can = may("operate") && joints !== null;
  const torque = (on: boolean, confirmed = false): void => {
    ask(false);
    const groups = new Map<string, string[]>();
    for (const name of names) {
      const owner = joints?.owners[name];
      if (owner) groups.set(owner, [...(groups.get(owner) ?? []), name]);
    }
    for (const [owner, group] of groups) void command(owner, "torque", { on, ...(confirmed ? { confirmed } : { joints: group }) });
    if (!on) onLive(true);
  };
  return (
    <Card title={t("motions.hands")} icon="power">
      <p class="motions-hint">{t("motions.hands.text")}</p>
      <Segments<Which> label={t("motions.hands.which")} value={which} onChange={choose} options={SIDES.map((value) => ({ value, text: t(`motions.hands.${value}`) }))} />
      <div class="joints-actions">
        <Button icon="power" disabled={!can || limp === names.length} onClick={() => (which === "all" ? ask(true) : torque(false))}>{t("motions.hands.release")}</Button>
        <Button icon="bolt" disabled={!can || held === names.length} onClick={() => torque(true)}>{t("motions.hands.hold")}</Button>
      </div>
      <Toggle label={t("motions.hands.live")} checked={live} disabled={joints === null} onChange={onLive} />
      <Button kind="primary" icon="camera" disabled={joints === null} onClick={onCapture}>{t("motions.add.robot")}</Button>
      <Dialog
        title={t("joints.release.title")} open={asks} onClose={() => ask(false)}
        actions={<><Button kind="quiet" autofocus onClick={() => ask(false)}>{t("dialog.cancel")}</Button><Button kind="danger" icon="power" onClick={() => torque(false, true)}>{t("joints.release.yes")}</Button></>}
      >
        <p>{t("joints.release.text", { robot: model.robot })}</p>
      </Dialog>
    </Card>
  );
}
