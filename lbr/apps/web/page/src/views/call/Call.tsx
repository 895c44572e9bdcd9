// Call: the robot's picture and sound, one's own, and who else is there.
import { call, caller, hangUp, hide, hush, ours, ring, silent, unseen } from "../../call";
import { named } from "../../handover";
import { useStream } from "../../live";
import type { CallState, CameraState } from "../../messages";
import { Badge, Button, Icon } from "../../parts";
import { capabilities, command, may, role } from "../../robot";
import { byCall, Film, Picture } from "../../stream";
import { clock } from "../../live";
import { t } from "../../words";
import "./Call.css";

export default function Call() {
  const name = caller()?.name ?? "";
  const state = useStream<CallState>(name ? `${name}/state` : "")?.message ?? null;
  const { stage } = call.value;
  return (
    <div class="call" data-stage={stage}>
      <h2 class="sr">{t("view.call")}</h2>
      <section class="call-stage" aria-label={t("call.stage.label")}>
        <Seen state={state} />
        <Top state={state} />
        {ours.value && !unseen.value && ours.value.getVideoTracks().length > 0 && <Film stream={ours.value} label={t("call.self")} muted mirrored class="call-self" />}
        <div class="call-buttons">{stage === "idle" ? <Idle state={state} /> : <During />}</div>
      </section>
      <Words state={state} />
    </div>
  );
}

function Seen({ state }: { state: CallState | null }) {
  const cameras = capabilities("camera").map((one) => one.name);
  const on = cameras.find((one) => one === `camera_${state?.camera}`) ?? cameras[0];
  const camera = useStream<CameraState>(on ? `${on}/state` : "");
  const off = camera !== null && !camera.message.on;
  const why = off ? t("call.camera.off") : call.value.stage === "talking" ? call.value.picture : "";
  if (why) return <div class="call-nopicture" role="status"><Icon name="camera" /><p>{off ? why : t("call.nopicture", { reason: why })}</p></div>;
  if (!on) return <div class="call-nopicture"><Icon name="camera" /><p>{t("drive.camera.none")}</p></div>;
  return <Picture name={on} />;
}

function Top({ state }: { state: CallState | null }) {
  void clock.value;
  const { stage, watches, since } = call.value;
  const told = stage === "talking" && watches ? t("call.stage.watching") : t(`call.stage.${stage}`);
  return (
    <div class="call-top">
      <p class="call-told" role="status" data-live={stage === "talking" || undefined}>
        <span class="call-dot" aria-hidden="true" />{told}{since > 0 && <time>{lasted(Date.now() - since)}</time>}
      </p>
      {byCall() ? <Badge tone="good">{t(watches ? "call.webrtc.watch" : "call.webrtc")}</Badge> : state?.picture ? null : <Badge>{t("call.mjpeg")}</Badge>}
    </div>
  );
}

function lasted(ms: number): string {
  const s = Math.max(0, Math.floor(ms / 1000));
  return `${Math.floor(s / 60)}:${String(s % 60).padStart(2, "0")}`;
}

function Idle({ state }: { state: CallState | null }) {
  const name = caller()?.name ?? "";
  const other = state !== null && state.phase !== "idle";
  if (other && state.phase === "ringing" && may("admin")) {
    return (
      <>
        <Button kind="primary" icon="phone" onClick={() => void command(name, "answer", {})}>{t("call.answer")}</Button>
        <Button kind="danger" icon="hangup" onClick={() => void command(name, "decline", {})}>{t("call.decline")}</Button>
      </>
    );
  }
  return (
    <>
      {!other && <Button kind="primary" class="call-go" icon="phone" disabled={!may("operate") || Boolean(state?.lacks)} onClick={() => void ring()}>{call.value.ended ? t("call.again") : t("call.call")}</Button>}
      {other && may("operate") && <Button icon="hangup" class="call-glass" onClick={() => void command(name, "end", {})}>{t("call.end.other")}</Button>}
      {!state?.lacks && <Button icon="eye" class="call-glass" onClick={() => void ring(true)}>{t("call.watch")}</Button>}
    </>
  );
}

function During() {
  const stream = ours.value;
  return (
    <>
      {stream && stream.getAudioTracks().length > 0 && <Button class="call-round" icon={silent.value ? "nomicrophone" : "microphone"} label={t("call.hush")} pressed={silent.value} onClick={() => hush(!silent.value)} />}
      {stream && stream.getVideoTracks().length > 0 && <Button class="call-round" icon={unseen.value ? "nocamera" : "camera"} label={t("call.hide")} pressed={unseen.value} onClick={() => hide(!unseen.value)} />}
      <Button class="call-round call-hangup" kind="danger" icon="hangup" label={t("call.end")} onClick={hangUp} />
    </>
  );
}

function Words({ state }: { state: CallState | null }) {
  const { stage, watches, lacks, hears, sound, seen, ended, was } = call.value;
  const other = stage === "idle" && state !== null && state.phase !== "idle";
  return (
    <div class="call-words">
      {state?.lacks && <p class="call-word" data-tone="warn"><Icon name="info" /><span>{t("call.mjpeg.why", { reason: state.lacks })}</span></p>}
      {ended && <p class="call-word" data-tone="warn" role="alert"><Icon name="info" /><span>{t(was ? "call.ended" : "call.mjpeg.why", { reason: ended.replace(/[.\s]+$/, "") })}</span></p>}
      {other && <p class="call-word" data-tone="warn"><Icon name="person" /><span>{t(state.phase === "ringing" ? "call.rings" : "call.other", { who: named(state.caller) })}</span></p>}
      {stage === "idle" && !other && !state?.lacks && <p class="call-word"><Icon name="phone" /><span>{may("operate") ? t(state?.at_once ? "call.at_once" : "call.asks") : t("call.role", { role: role.value ?? "" })}</span></p>}
      {lacks && <p class="call-word" data-tone="warn"><Icon name="warn" /><span>{lacks}</span></p>}
      {stage === "talking" && !watches && (
        <>
          <p class="call-word" data-tone={seen ? "good" : "warn"}><Icon name={seen ? "check" : "info"} /><span>{t(seen ? "call.seen" : "call.seen.no")}</span></p>
          <p class="call-word" data-tone={hears === "silence" ? "warn" : undefined}><Icon name={hears === "silence" ? "hush" : "speak"} /><span>{t(`call.hears.${hears}`)}{hears === "silence" && <small>{sound}</small>}</span></p>
        </>
      )}
      <p class="call-word"><Icon name="drive" /><span>{t("call.drive")}</span></p>
    </div>
  );
}
