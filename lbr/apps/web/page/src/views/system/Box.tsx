// The black box: keep what led to this moment, record on purpose, and take recordings along.
import { useEffect, useState } from "preact/hooks";
import { told } from "../../access";
import { number } from "../../format";
import { useStream } from "../../live";
import type { BoxState, Capability } from "../../messages";
import { notice } from "../../notices";
import { Button, Dialog, Icon } from "../../parts";
import { capabilities, command, fetchJson, may } from "../../robot";
import { t } from "../../words";

interface Recording { name: string; bytes: number }

export function Box() {
  const box = capabilities("box").find((one) => one.commands["mark"] && may(one.commands["mark"].role));
  return box ? <Tools of={box} /> : null;
}

function Tools({ of }: { of: Capability }) {
  const state = useStream<BoxState>(`${of.name}/state`)?.message;
  const recording = Boolean(state?.recording);
  const [all, tell] = useState<Recording[] | null>(null);
  const [lists, list] = useState(false);
  const look = async (): Promise<void> => tell((await fetchJson<Recording[]>("recordings", { quiet: true })).data);
  useEffect(() => void look(), [recording]);
  const ask = async (name: string, message: unknown, effect = ""): Promise<boolean> => {
    const answer = await command(of.name, name, message, { quiet: true });
    notice(answer.ok ? effect || answer.data?.reason || t("box.done") : told(answer), answer.ok ? "good" : "warn");
    return answer.ok;
  };
  const end = async (): Promise<void> => {
    if (!(await ask("end", {}))) return;
    await look();
    list(true);
  };
  return (
    <div class="system-box" role="group" aria-label={t("box.title")}>
      <Button kind="quiet" icon="mark" onClick={() => void ask("mark", {}, t("box.marked"))}>{t("box.mark")}</Button>
      <Button kind={recording ? "danger" : "quiet"} icon={recording ? "pause" : "record"} onClick={() => void (recording ? end() : ask("record", { cameras: true }, t("box.records")))}>
        {recording ? t("box.end") : t("box.record")}
      </Button>
      {Array.isArray(all) && <Button kind="quiet" icon="save" onClick={() => { void look(); list(true); }}>{t("box.recordings")}</Button>}
      <Dialog title={t("box.recordings")} open={lists && Array.isArray(all)} onClose={() => list(false)}>
        {all?.length === 0 ? <p class="muted">{t("box.none")}</p> : (
          <ul class="recordings">
            {all?.map?.((one) => (
              <li key={one.name}>
                <a class="button button-plain" href={`recordings/${encodeURIComponent(one.name)}`} download={one.name}><Icon name="save" /><span>{one.name}</span></a>
                <span class="muted num">{number(one.bytes / 1e6, 1)} MB</span>
              </li>
            ))}
          </ul>
        )}
      </Dialog>
      {recording && <span class="muted num">{t("box.size", { size: number(state?.recording_mb ?? 0, 1) })}</span>}
    </div>
  );
}
