// Behaviours: the robot's state tables. One is chosen, run, watched and edited; what is wrong stands beside its cell.
import { useEffect, useState } from "preact/hooks";
import { plain } from "../../format";
import { remember, remembered } from "../../kept";
import { useStream } from "../../live";
import { Badge, Card, Empty, Icon } from "../../parts";
import { may, streamOfType } from "../../robot";
import { learn, t } from "../../words";
import { behaviours as behavioursWords } from "../../words/behaviours";
import type { Run, Summary, Tables } from "./data";
import { Import, New } from "./Files";
import { Opened } from "./Opened";
import "./Behaviours.css";

learn(behavioursWords);

const going = (run: Run | null): boolean => run !== null && (run.phase === "running" || run.phase === "paused");

export default function Behaviours() {
  const stream = streamOfType("BehaviourState");
  const owner = stream.split("/")[0] ?? "";
  const run = useStream<Run>(stream)?.message ?? null;
  const told = useStream<Tables>(streamOfType("BehaviourTables"))?.message;
  const tables = told?.tables ?? [];
  const [chosen, choose] = useState<string>(remembered("behaviour", ""));
  const runs = going(run) ? run!.called[0] ?? run!.table : "";
  useEffect(() => { if (!chosen && runs) choose(runs); }, [runs]);
  const pick = (name: string): void => { choose(name); remember("behaviour", name); };
  const now = tables.find((one) => one.name === chosen) ?? (chosen ? undefined : tables[0]);
  const tools = may("admin") && <div class="behaviours-files"><Import owner={owner} tables={tables} onTaken={pick} /><New tables={tables} onMade={pick} /></div>;
  if (!told) return null;  // they come at once; until then none are said to be missing
  if (tables.length === 0) return <Empty icon="behaviours" title={t("behaviours.none")}><p>{t("behaviours.none.text")}</p>{tools}</Empty>;
  return (
    <div class="behaviours">
      <Card title={t("behaviours.tables")} icon="behaviours" class="behaviours-list">
        <ul>
          {tables.map((one) => <li key={one.name}><Entry of={one} runs={runs === one.name} chosen={one === now} onPick={() => pick(one.name)} /></li>)}
        </ul>
        {tools}
      </Card>
      {now ? <Opened key={now.name} owner={owner} of={now} run={run} runs={runs} onPick={pick} /> : <Empty icon="behaviours" title={t("behaviours.pick")} />}
    </div>
  );
}

function Entry({ of, runs, chosen, onPick }: { of: Summary; runs: boolean; chosen: boolean; onPick: () => void }) {
  const wrong = of.faults.filter((one) => one.error).length;
  return (
    <button type="button" class="behaviours-entry" aria-pressed={chosen} onClick={onPick}>
      <strong>{plain(of.name)}</strong>
      {runs ? <Badge tone="good" icon="play">{t("behaviours.runs")}</Badge> : wrong > 0 ? <Badge tone="warn" icon="warn">{t("behaviours.faults", { count: wrong })}</Badge> : <Icon name="check" />}
      {of.help && <span class="muted">{of.help}</span>}
    </button>
  );
}
