// The motion that is played: which, how far it is, and its end.
import { told } from "../../access";
import { number } from "../../format";
import { Mend } from "../../mend";
import { useNews } from "../../news";
import { toldLately } from "../../notices";
import { Button, Icon } from "../../parts";
import { toldStop } from "../../stopping";
import { deedName, t } from "../../words";
import { Outline } from "../joints/Flat";
import { jointStreams } from "../joints/hooks";
import type { BodyModel } from "../joints/model";
import type { MotionsState } from "./data";
import "./Playing.css";

interface Props { state?: MotionsState; part: number; said?: string; model?: BodyModel | null; onStop: () => void }

/** `said`: what stands beside it already; `model`: the body that is shown as it moves, where nothing else shows it. */
export function Playing({ state, part, said = "", model, onStop }: Props) {
  const fresh = useNews(state ? (state.playing ? "" : `${state.code ?? ""} ${state.reason ?? ""}`.trim()) : null);
  if (!state?.playing) {
    const why = fresh && state?.reason && state.code && !["done", "idle", "", "cancelled", "estop", "lapsed", "holder_gone"].includes(state.code) ? told({ code: state.code, reason: state.reason }) : "";
    return why && why !== said && !toldLately(why) && !toldStop(state?.code) ? <div class="motions-why" role="status"><Icon name="info" /><p>{why}</p><Mend code={state?.code ?? ""} /></div> : null;
  }
  return (
    <section class="motions-playing" aria-label={t("motions.playing", { motion: deedName(state.motion ?? "") })}>
      <div class="motions-bar" role="progressbar" aria-valuemin={0} aria-valuemax={100} aria-valuenow={Math.round(100 * part)}><span style={{ width: `${100 * part}%` }} /></div>
      {model && model.links.length > 0 && <div class="motions-now"><Outline model={model} streams={jointStreams()} selected="" onPick={() => undefined} /></div>}
      <p><strong class="motions-name">{deedName(state.motion ?? "")}</strong>
        <span>{[
          (state.frames ?? 0) > 1 ? t("motions.frame", { frame: state.frame ?? 0, of: state.frames ?? 0 }) : "",
          (state.times ?? 1) > 1 ? t("motions.round", { round: state.round ?? 1, of: state.times ?? 1 }) : "",
          state.left_s != null ? t("motions.left", { s: number(state.left_s, 1) }) : "",
        ].filter(Boolean).join(" · ")}</span>
      </p>
      <Button kind="danger" icon="stop" onClick={onStop}>{t("motions.end")}</Button>
    </section>
  );
}
