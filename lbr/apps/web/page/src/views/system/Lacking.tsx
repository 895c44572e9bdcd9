// Of a robot that is being built: what is missing, in which order it is mended. All else can be used.
import { useEffect, useState } from "preact/hooks";
import { plain } from "../../format";
import { status } from "../../live";
import { Button } from "../../parts";
import { consoleLine, fetchJson, knows, may } from "../../robot";
import { learn, t } from "../../words";
import { system } from "../../words/system";
import { feedsOf, ill, lacks, type Chain, type Lack } from "./mending";
import { Log } from "./Log";
import { table } from "./manage";
import "./Lacking.css";

learn(system);
const MOST = 24;

export default function Lacking() {
  const parts = status.value?.capabilities ?? [];
  const names = parts.filter(ill).map((one) => one.name).slice(0, MOST);
  const [chains, tell] = useState<Record<string, Chain>>({});
  const [feeds, hear] = useState<Record<string, string[]>>({});
  const [log, read] = useState("");
  useEffect(() => {
    let over = false;
    if (may("operate")) void table("channel").then((answer) => { if (!over && answer.ok) hear(feedsOf(answer.data?.data?.rows ?? [])); });
    const ask = async (): Promise<void> => {
      for (const name of names) {
        const answer = await fetchJson<Chain>(`api/why/${name}`, { quiet: true });
        if (over) return;
        if (answer.ok && answer.data) tell((known) => ({ ...known, [name]: answer.data! }));
      }
    };
    void ask();
    return () => { over = true; };
  }, [names.join(" "), status.value?.revision]);
  if (names.length === 0) return <p class="muted">{t("lacking.none")}</p>;
  return (
    <>
      <p class="muted">{t("lacking.rest")}</p>
      <ol class="lacking">{lacks(parts, chains, feeds).map((one) => <One key={one.root} of={one} onLog={() => read(one.root)} />)}</ol>
      {log && <Log name={log} onClose={() => read("")} />}
    </>
  );
}

function One({ of, onLog }: { of: Lack; onLog: () => void }) {
  const [, name] = /\/restart\/([a-z0-9_]+)/.exec(of.do) ?? [];
  const logged = of.do.includes("logs/") && may("operate");
  return (
    <li>
      <div>
        <p><strong>{plain(of.root)}</strong> <span lang="en">{of.reason}</span></p>
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
