// The robot's own screen: its face, or the picture and the voice of who calls it.
import { useEffect, useRef, useState } from "preact/hooks";
import { unknown } from "../../access";
import { connect, type Connection } from "../../connection";
import { named } from "../../handover";
import { useStream } from "../../live";
import type { CallState, SpeechState } from "../../messages";
import { Button } from "../../parts";
import { capabilities, command, may, robot, streamOfType } from "../../robot";
import { SignIn } from "../../sign-in";
import { Film } from "../../stream";
import { t } from "../../words";
import "./Display.css";

const AGAIN_MS = 1000;

export default function Display() {
  if (!robot.value) return <main class="display">{unknown.value ? <SignIn /> : <Face />}</main>;
  return <main class="display" id="main"><Shown /></main>;
}

function Shown() {
  const name = capabilities("call")[0]?.name ?? "";
  const state = useStream<CallState>(name ? `${name}/state` : "");
  const phase = state === null || state.stale(4000) ? "idle" : state.message.phase;
  const stream = useCaller(phase === "talking" || phase === "connecting");
  const [blocked, block] = useState(false);
  const [heard, hear] = useState(0);
  const who = named(state?.message.caller ?? "");
  if (stream && phase === "talking") {
    return (
      <section class="display-call" aria-label={t("display.caller", { who })}>
        <Film key={heard} stream={stream} label={t("display.caller", { who })} muted={false} class="display-film" onBlocked={block} />
        <p class="display-who">{who}</p>
        {blocked && <Button class="display-sound" kind="primary" icon="speak" onClick={() => hear(heard + 1)}>{t("display.sound")}</Button>}
      </section>
    );
  }
  return (
    <>
      <Face rings={phase === "ringing"} />
      {phase === "ringing" && (
        <div class="display-rings" role="alert">
          <p>{t("display.wait", { who })}</p>
          {may("admin") && (
            <div class="display-answers">
              <Button kind="primary" icon="phone" onClick={() => void command(name, "answer", {})}>{t("call.answer")}</Button>
              <Button kind="danger" icon="hangup" onClick={() => void command(name, "decline", {})}>{t("call.decline")}</Button>
            </div>
          )}
        </div>
      )}
    </>
  );
}

/** What comes of the caller, for as long as there is one; asked for again when it is lost. */
function useCaller(wanted: boolean): MediaStream | null {
  const [stream, show] = useState<MediaStream | null>(null);
  const [turn, again] = useState(0);
  const made = useRef<Connection | null>(null);
  useEffect(() => {
    if (!wanted) return undefined;
    let later: ReturnType<typeof setTimeout> | undefined;
    made.current = connect({
      purpose: "display",
      onMedia: show,
      onNews: () => undefined,
      onEnd: () => { show(null); later = setTimeout(() => again((n) => n + 1), AGAIN_MS); },
    });
    return () => {
      clearTimeout(later);
      made.current?.close();
      made.current = null;
      show(null);
    };
  }, [wanted, turn]);
  return wanted ? stream : null;
}

function Face({ rings = false }: { rings?: boolean }) {
  const speech = useStream<SpeechState>(robot.value ? streamOfType("SpeechState") : "");
  const speaks = speech?.message.speaking === true && !speech.stale(4000);
  return (
    <svg class="display-face" viewBox="0 0 320 200" role="img" aria-label={t("display.face")} data-rings={rings || undefined} data-speaks={speaks || undefined}>
      <g class="display-eyes">
        <g class="display-eye"><rect x="70" y="46" width="52" height="72" rx="26" /><circle cx="104" cy="70" r="9" /></g>
        <g class="display-eye"><rect x="198" y="46" width="52" height="72" rx="26" /><circle cx="232" cy="70" r="9" /></g>
      </g>
      <path class="display-mouth" d="M128 150q32 22 64 0" />
    </svg>
  );
}
