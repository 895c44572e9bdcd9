// The robot's parts: state, reason, load and rates; restarted by an admin.
import { useEffect, useState } from "preact/hooks";
import { told as told_ } from "../../access";
import { age, number, plain } from "../../format";
import { status } from "../../live";
import type { CapabilityStatus } from "../../messages";
import { notice } from "../../notices";
import { Badge, Button, Dialog, Empty, Field, type BadgeTone, type IconName } from "../../parts";
import { capabilities, consoleLine, knows, may, robot } from "../../robot";
import { maybe, t } from "../../words";
import { Log } from "./Log";
import { changeAll, table } from "./manage";
import { noteMade } from "./undo";

const TONES: Record<string, [BadgeTone, IconName]> = {
  ready: ["good", "check"], starting: ["calm", "restart"], waiting: ["calm", "pause"], stopping: ["calm", "pause"], stopped: ["calm", "pause"], degraded: ["warn", "warn"], failed: ["bad", "warn"],
};
const ORDER = ["failed", "degraded", "starting", "waiting", "stopping", "ready", "stopped"];

export function Parts() {
  const [wanted, find] = useState("");
  const [restarts, ask] = useState("");
  const [log, read] = useState("");
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
    const said = t(on ? "system.enabled" : "system.disabled", { name: plain(name) });
    if (answer.ok) noteMade(said, [one], [["name"]]);
    if (answer.ok) notice(said, "good");
    else notice(told_(answer), "warn");
  };
  const told = status.value;
  const all: CapabilityStatus[] = told?.capabilities ?? (robot.value?.capabilities ?? []).map((one) => ({ name: one.name, kind: one.kind, phase: one.phase ?? "", pid: null, restarts: 0, uptime_s: null, reason: one.reason ?? "", rates_hz: {} }));
  const shown = all.filter((one) => `${one.name} ${one.kind} ${one.phase}`.includes(wanted.trim().toLowerCase())).sort((one, other) => ORDER.indexOf(one.phase) - ORDER.indexOf(other.phase) || one.name.localeCompare(other.name));
  const bad = all.filter((one) => one.phase === "failed" || one.phase === "degraded").length;
  const restart = async (name: string): Promise<void> => {
    ask("");
    const answer = await consoleLine(`/restart/${name}`);
    if (answer.ok) notice(t("system.restarted", { name }), "good");
  };
  return (
    <div class="stack">
      <div class="system-tools">
        <Badge tone={bad > 0 ? "warn" : "good"} icon={bad > 0 ? "warn" : "check"}>{bad > 0 ? t("system.problems", { count: bad }) : t("system.ready")}</Badge>
        {told && <span class="muted num">{t("system.up")} {age((told.uptime_s ?? 0) * 1000)}</span>}
        <div class="system-find"><Field label={t("system.filter")} type="search" value={wanted} onInput={(event) => find(event.currentTarget.value)} /></div>
      </div>
      {told?.problems?.map((one) => <p key={one} class="system-problem">{one}</p>)}
      {shown.length === 0 ? <Empty icon="search" title={t("system.nothing")} /> : <ul class="system-parts">{shown.map((one) => <Part key={one.name} part={one} onRestart={knows("restart") ? () => ask(one.name) : undefined} onLog={may("operate") ? () => read(one.name) : undefined} onDisable={may("admin") ? () => part(one.name) : undefined} />)}</ul>}
      {disabled.length > 0 && (
        <section class="system-off" aria-label={t("system.off")}>
          <h3>{t("system.off")}</h3>
          <ul>{disabled.map((name) => <li key={name}><span>{plain(name)}</span>{may("admin") && <Button kind="quiet" onClick={() => void enable(name, true)}>{t("system.enable")}</Button>}</li>)}</ul>
        </section>
      )}
      <Dialog
        title={t("system.disable.title", { name: plain(leaving) })} open={leaving !== ""} onClose={() => part("")}
        actions={<><Button kind="quiet" onClick={() => part("")}>{t("dialog.cancel")}</Button><Button kind="danger" icon="pause" onClick={() => { part(""); void enable(leaving, false); }}>{t("system.disable")}</Button></>}
      ><p>{t("system.disable.text")}</p></Dialog>
      {log && <Log name={log} onClose={() => read("")} />}
      <Dialog
        title={t("system.restart.title", { name: restarts })} open={restarts !== ""} onClose={() => ask("")}
        actions={<><Button kind="quiet" onClick={() => ask("")}>{t("dialog.cancel")}</Button><Button kind="primary" icon="restart" onClick={() => void restart(restarts)}>{t("system.restart")}</Button></>}
      ><p>{t("system.restart.text")}</p></Dialog>
    </div>
  );
}

function Part({ part, onRestart, onLog, onDisable }: { part: CapabilityStatus; onRestart?: () => void; onLog?: () => void; onDisable?: () => void }) {
  const [tone, icon] = TONES[part.phase] ?? ["calm", "info"];
  const summary = capabilities(part.kind).find((one) => one.name === part.name)?.summary ?? "";
  const rates = Object.entries(part.rates_hz).filter(([, rate]) => rate > 0.05);
  return (
    <li class="system-part" data-tone={tone}>
      <div class="system-part-head">
        <h3 class="cut">{plain(part.name)}</h3>
        <Badge tone={tone} icon={icon}>{maybe(`phase.${part.phase}`) || part.phase}</Badge>
      </div>
      <p class="system-part-reason">{part.reason || summary || part.kind}</p>
      {part.last_end && <p class="system-part-reason muted">{part.last_end}</p>}
      <dl class="system-part-facts num">
        {part.cpu_percent != null && <div><dt>{t("system.cpu")}</dt><dd>{number(part.cpu_percent, 1)} %</dd></div>}
        {part.memory_mb != null && <div><dt>{t("system.memory")}</dt><dd>{number(part.memory_mb)} MB</dd></div>}
        {part.process && <div><dt>{t("system.process")}</dt><dd>{plain(part.process)}</dd></div>}
        {part.restarts > 0 && <div><dt>{t("system.restarts")}</dt><dd>{part.restarts}</dd></div>}
        {rates.map(([name, rate]) => <div key={name}><dt>{plain(name)}</dt><dd>{number(rate, rate < 10 ? 1 : 0)} Hz</dd></div>)}
      </dl>
      <div class="system-part-actions">
        {onRestart && <Button kind="quiet" icon="restart" label={`${t("system.restart")}: ${part.name}`} onClick={onRestart} />}
        {onLog && <Button kind="quiet" icon="log" label={`${t("system.log")}: ${part.name}`} onClick={onLog} />}
        {onDisable && <Button kind="quiet" icon="pause" label={`${t("system.disable")}: ${part.name}`} onClick={onDisable} />}
      </div>
    </li>
  );
}
