// Of a robot that is being built: what is missing, in which order it is mended. All else can be used.
import { useEffect, useState } from "preact/hooks";
import { plain } from "../../format";
import { ill } from "../../lacking";
import { status } from "../../live";
import { Button } from "../../parts";
import { consoleLine, fetchJson, knows, may } from "../../robot";
import { learn, t } from "../../words";
import { system } from "../../words/system";
import { Log } from "./Log";
import "./Lacking.css";

learn(system);
/** What the robot says is to be mended, in which order. */
interface Repair { part: string; text: string; do: string; device: boolean; waits: string[] }

export default function Lacking() {
  const names = (status.value?.capabilities ?? []).filter(ill).map((one) => one.name);
  const [repairs, tell] = useState<Repair[]>([]);
  const [log, read] = useState("");
  useEffect(() => {
    let over = false;
    void fetchJson<{ repairs: Repair[] }>("api/why", { quiet: true }).then((answer) => { if (!over && answer.ok) tell(answer.data?.repairs ?? []); });
    return () => { over = true; };
  }, [names.join(" "), status.value?.revision]);
  if (names.length === 0) return <p class="muted">{t("lacking.none")}</p>;
  return (
    <>
      <p class="muted">{t("lacking.rest")}</p>
      <ol class="lacking">{repairs.map((one) => <One key={one.part} of={one} onLog={() => read(one.part)} />)}</ol>
      {log && <Log name={log} onClose={() => read("")} />}
    </>
  );
}

function One({ of, onLog }: { of: Repair; onLog: () => void }) {
  const [, name] = /\/restart\/([a-z0-9_]+)/.exec(of.do) ?? [];
  const logged = of.do.includes("logs/") && may("operate");
  return (
    <li>
      <div>
        <p><strong>{plain(of.part)}</strong> <span lang="en">{of.text}</span></p>
        {of.do && !name && !of.device && <p class="muted" lang="en">{of.do}</p>}
        {of.waits.length > 0 && <p class="muted">{t("lacking.waits", { names: of.waits.map(plain).join(", ") })}</p>}
      </div>
      <div class="lacking-ways">
        {of.device && may("admin") && <Button icon="plus" onClick={() => { location.hash = "system/devices"; }}>{t("system.devices")}</Button>}
        {name && knows("restart") && <Button icon="restart" onClick={() => void consoleLine(`/restart/${name}`)}>{t("system.restart")}</Button>}
        {logged && <Button icon="log" onClick={onLog}>{t("system.log")}</Button>}
      </div>
    </li>
  );
}
