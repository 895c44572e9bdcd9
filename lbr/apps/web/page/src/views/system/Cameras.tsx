// The robot's cameras: what each sees, its privacy switch, and a picture to keep.
import type { AllCSSProperties } from "preact";
import { inWords } from "../../access";
import { age as ageText, number, plain } from "../../format";
import { useStream } from "../../live";
import type { Capability, CameraState } from "../../messages";
import { notice } from "../../notices";
import { Badge, Button, Icon, Toggle } from "../../parts";
import { capabilities, command, may } from "../../robot";
import { save } from "../../saving";
import { Picture, PREFIX, usePictureAge } from "../../stream";
import { maybe, t } from "../../words";

/** The state of a camera comes once a second. */
const OLD_MS = 4000;

export function Cameras() {
  return <div class="cameras">{capabilities("camera").map((one) => <Camera key={one.name} of={one} />)}</div>;
}

function Camera({ of }: { of: Capability }) {
  const state = useStream<CameraState>(`${of.name}/state`);
  const told = state?.message;
  const age = usePictureAge(state);
  const snapshot = async (): Promise<void> => {
    const answer = await command(of.name, "snapshot", {});
    if (!answer.ok) return;
    const picture = await fetch(`snapshot.jpg?camera=${encodeURIComponent(of.name.replace(PREFIX, ""))}`).catch(() => null);
    if (picture?.ok) save(`${of.name}.jpg`, new Uint8Array(await picture.arrayBuffer()));
    notice(t(picture?.ok ? "cameras.kept" : "cameras.kept.robot"), "good");
  };
  return (
    <section class="camera" aria-label={plain(of.name)}>
      <div class="system-part-head">
        <h3 class="cut">{plain(of.name.replace(PREFIX, ""))}</h3>
        {told && <Badge tone={told.on ? (told.phase === "ready" || told.phase === "streaming" ? "good" : "calm") : "calm"}>{told.on ? maybe(`cameras.phase.${told.phase}`) || told.phase : t("cameras.phase.off")}</Badge>}
      </div>
      <div class="camera-picture" style={told?.width_px && told.height_px ? { "--shape": `${told.width_px} / ${told.height_px}` } as AllCSSProperties : undefined}>{told && !told.on ? <><Icon name="nocamera" /><p>{t("cameras.off")}</p></> : <Picture name={of.name} />}</div>
      <p class="camera-facts muted num">{age !== null && told?.on && <Badge tone={age > OLD_MS ? "warn" : "good"} icon={age > OLD_MS ? "warn" : undefined}>{age > OLD_MS ? t("cameras.age", { age: ageText(age) }) : t("cameras.live")}</Badge>} {told?.width_px ? `${told.width_px} × ${told.height_px}` : ""}{told?.fps ? ` · ${number(told.fps, 1)} / s` : ""}{told?.reason ? ` ${inWords(told)}` : ""}</p>
      <div class="system-tools">
        {of.commands["switch"] && <Toggle label={t("cameras.private")} checked={told?.on ?? false} disabled={!told || !may(of.commands["switch"].role)} onChange={(on) => void command(of.name, "switch", { on })} />}
        {of.commands["snapshot"] && may(of.commands["snapshot"].role) && <Button icon="camera" disabled={told?.on === false} onClick={() => void snapshot()}>{t("cameras.keep")}</Button>}
      </div>
    </section>
  );
}
