// The robot's parts, a line each: state, reason and load; opened: rates, events, log, and what an admin does to it.
import { useEffect, useState } from "preact/hooks";
import { inWords, told } from "../../access";
import { age, number, plain } from "../../format";
import { status } from "../../live";
import type { CapabilityStatus } from "../../messages";
import { notice } from "../../notices";
import { Badge, Button, Dialog, Empty, Field, useOwnId, type BadgeTone, type IconName } from "../../parts";
import { capabilities, consoleLine, knows, may, robot } from "../../robot";
import { maybe, t } from "../../words";
import { EventList, useEvents } from "./Events";
import { Log } from "./Log";
import { changeAll, table } from "./manage";
import { lineOf, minute } from "./minute";
import { noteMade } from "./undo";

const TONES: Record<string, [BadgeTone, IconName]> = {
  ready: ["good", "check"], starting: ["calm", "restart"], waiting: ["calm", "pause"], stopping: ["calm", "pause"], stopped: ["calm", "pause"], degraded: ["warn", "warn"], failed: ["bad", "warn"],
};
const EVENTS = 6;
const ORDER = ["failed", "degraded", "starting", "waiting", "stopping", "ready", "stopped"];

export function Parts() {
  const [wanted, find] = useState("");
  const [restarts, ask] = useState("");
  const [log, read] = useState("");
  const [opened, open] = useState<ReadonlySet<string>>(new Set());
  const [leaving, part] = useState("");
  const [off, setOff] = useState<string[]>([]);
  const disabled = may("operate") ? off : [];
  useEffect(() => {
    if (may("operate")) void table("capability").then((answer) => setOff((answer.data?.data?.rows ?? []).filter((row) => row["enabled"] === false).map((row) => String(row["name"]))));
  }, [status.value?.revision]);
  const enable = async (name: string, on: boolean): Promise<void> => {
    const row = (await table("capability")).data?.data?.rows.find((one) => one["name"] === name);
    if (!row) return;
    const one = { table: "capability", before: row, after: { enabled: on } };
    const answer = await changeAll([one], true, true);
    const text = t(on ? "system.enabled" : "system.disabled", { name: plain(name) });
    if (answer.ok) noteMade(text, plain(name), answer);
    if (answer.ok) notice(text, "good");
    else notice(told(answer), "warn");
  };
  const now = status.value;
  const all: CapabilityStatus[] = now?.capabilities ?? (robot.value?.capabilities ?? []).map((one) => ({ name: one.name, kind: one.kind, phase: one.phase ?? "", pid: null, restarts: 0, uptime_s: null, reason: one.reason ?? "", rates_hz: {} }));
  const shown = all.filter((one) => `${one.name} ${one.kind} ${one.phase}`.includes(wanted.trim().toLowerCase())).sort((one, other) => ORDER.indexOf(one.phase) - ORDER.indexOf(other.phase) || one.name.localeCompare(other.name));
  const bad = all.filter((one) => one.phase === "failed" || one.phase === "degraded").length;
  const restart = async (name: string): Promise<void> => {
    ask("");
    const answer = await consoleLine(`/restart/${name}`);
    if (answer.ok) notice(t("system.restarted", { name: plain(name) }), "good");
  };
  return (
    <div class="stack">
      <div class="system-tools">
        <Badge tone={bad > 0 ? "warn" : "good"} icon={bad > 0 ? "warn" : "check"}>{bad > 0 ? t("system.problems", { count: bad }) : t("system.ready")}</Badge>
        {now && <span class="muted num">{t("system.up")} {age((now.uptime_s ?? 0) * 1000)}</span>}
        <div class="system-find"><Field label={t("system.filter")} type="search" value={wanted} onInput={(event) => find(event.currentTarget.value)} /></div>
      </div>
      {now?.problems?.map((one) => <p key={one} class="system-problem">{one}</p>)}
      {shown.length === 0 ? <Empty icon="search" title={t("system.nothing")} /> : <ul class="parts">{shown.map((one) => <Part key={one.name} part={one} open={opened.has(one.name)} onOpen={(on) => open(new Set(on ? [...opened, one.name] : [...opened].filter((name) => name !== one.name)))} onRestart={knows("restart") ? () => ask(one.name) : undefined} onLog={may("operate") ? () => read(one.name) : undefined} onDisable={may("admin") ? () => part(one.name) : undefined} />)}</ul>}
      {disabled.length > 0 && (
        <section class="system-off" aria-label={t("system.off")}>
          <h3>{t("system.off")}</h3>
          <ul>{disabled.map((name) => <li key={name}><span>{plain(name)}</span>{may("admin") && <Button kind="quiet" label={`${t("system.enable")}: ${plain(name)}`} onClick={() => void enable(name, true)}>{t("system.enable")}</Button>}</li>)}</ul>
        </section>
      )}
      <Dialog
        title={t("system.disable.title", { name: plain(leaving) })} open={leaving !== ""} onClose={() => part("")}
        actions={<><Button kind="quiet" onClick={() => part("")}>{t("dialog.cancel")}</Button><Button kind="danger" icon="pause" onClick={() => { part(""); void enable(leaving, false); }}>{t("system.disable")}</Button></>}
      ><p>{t("system.disable.text")}</p></Dialog>
      {log && <Log name={log} onClose={() => read("")} />}
      <Dialog
        title={t("system.restart.title", { name: plain(restarts) })} open={restarts !== ""} onClose={() => ask("")}
        actions={<><Button kind="quiet" onClick={() => ask("")}>{t("dialog.cancel")}</Button><Button kind="primary" icon="restart" onClick={() => void restart(restarts)}>{t("system.restart")}</Button></>}
      ><p>{t("system.restart.text")}</p></Dialog>
    </div>
  );
}

interface PartProps { part: CapabilityStatus; open: boolean; onOpen: (open: boolean) => void; onRestart?: () => void; onLog?: () => void; onDisable?: () => void }

/** One part as a line; opened, all that is known of it. */
function Part({ part, open, onOpen, onRestart, onLog, onDisable }: PartProps) {
  const [tone, icon] = TONES[part.phase] ?? ["calm", "info"];
  const summary = capabilities(part.kind).find((one) => one.name === part.name)?.summary ?? "";
  const id = useOwnId();
  return (
    <li class="part" data-tone={tone}>
      <div class="part-line">
        <h3 class="cut"><button type="button" aria-expanded={open} aria-controls={id} onClick={() => onOpen(!open)}>{plain(part.name)}</button></h3>
        <p class="part-said">{inWords(part) || summary || part.kind}</p>
        <span class="part-load num"><Spark name={part.name} />{part.cpu_percent == null ? "" : `${number(part.cpu_percent)} %`}</span>
        <Badge tone={tone} icon={icon}>{maybe(`phase.${part.phase}`) || part.phase}</Badge>
      </div>
      <div id={id} class="part-more" hidden={!open}>{open && <More part={part} summary={summary} onRestart={onRestart} onLog={onLog} onDisable={onDisable} />}</div>
    </li>
  );
}

function Spark({ name }: { name: string }) {
  return <svg class="part-spark" viewBox="0 0 60 20" preserveAspectRatio="none" aria-hidden="true"><path d={lineOf(minute.value[name] ?? [])} /></svg>;
}

function More({ part, summary, onRestart, onLog, onDisable }: Omit<PartProps, "open" | "onOpen"> & { summary: string }) {
  const { shown } = useEvents(part.name, "info", EVENTS);
  const rates = Object.entries(part.rates_hz).filter(([, rate]) => rate > 0.05);
  const load = minute.value[part.name] ?? [];
  return (
    <>
      {part.reason && <p class="muted">{summary}</p>}
      {part.last_end && <p class="part-end">{part.last_end}</p>}
      <dl class="part-facts num">
        {load.length > 0 && <div><dt>{t("system.minute")}</dt><dd><Spark name={part.name} />{t("system.most", { value: number(Math.max(...load)) })}</dd></div>}
        {part.memory_mb != null && <div><dt>{t("system.memory")}</dt><dd>{number(part.memory_mb)} MB</dd></div>}
        {part.uptime_s != null && <div><dt>{t("system.up")}</dt><dd>{age(part.uptime_s * 1000)}</dd></div>}
        {part.process && <div><dt>{t("system.process")}</dt><dd>{plain(part.process)}</dd></div>}
        {part.restarts > 0 && <div><dt>{t("system.restarts")}</dt><dd>{part.restarts}</dd></div>}
        {rates.map(([name, rate]) => <div key={name}><dt>{plain(name)}</dt><dd>{number(rate, rate < 10 ? 1 : 0)} Hz</dd></div>)}
      </dl>
      <div class="system-tools">
        {onLog && <Button icon="log" label={`${t("system.log")}: ${part.name}`} onClick={onLog}>{t("system.log")}</Button>}
        {onRestart && <Button icon="restart" label={`${t("system.restart")}: ${part.name}`} onClick={onRestart}>{t("system.restart")}</Button>}
        {onDisable && <Button icon="pause" label={`${t("system.disable")}: ${part.name}`} onClick={onDisable}>{t("system.disable")}</Button>}
      </div>
      {shown.length > 0 && <EventList shown={shown} />}
    </>
  );
}
