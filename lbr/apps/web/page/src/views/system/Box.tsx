// The black box: keep what led to this moment, and record on purpose.
import { told } from "../../access";
import { number } from "../../format";
import { useStream } from "../../live";
import type { BoxState, Capability } from "../../messages";
import { notice } from "../../notices";
import { Button } from "../../parts";
import { capabilities, command, may } from "../../robot";
import { t } from "../../words";

export function Box() {
  const box = capabilities("box").find((one) => one.commands["mark"] && may(one.commands["mark"].role));
  return box ? <Tools of={box} /> : null;
}

function Tools({ of }: { of: Capability }) {
  const state = useStream<BoxState>(`${of.name}/state`)?.message;
  const recording = Boolean(state?.recording);
  const ask = async (name: string, message: unknown, effect = ""): Promise<void> => {
    const answer = await command(of.name, name, message, { quiet: true });
    notice(answer.ok ? effect || answer.data?.reason || t("box.done") : told(answer), answer.ok ? "good" : "warn");
  };
  return (
    <div class="system-box" role="group" aria-label={t("box.title")}>
      <Button kind="quiet" icon="mark" onClick={() => void ask("mark", {})}>{t("box.mark")}</Button>
      <Button kind={recording ? "danger" : "quiet"} icon={recording ? "pause" : "record"} onClick={() => void (recording ? ask("end", {}) : ask("record", { cameras: true }, t("box.records")))}>
        {recording ? t("box.end") : t("box.record")}
      </Button>
      {recording && <span class="muted num">{t("box.size", { size: number(state?.recording_mb ?? 0, 1) })}</span>}
    </div>
  );
}
