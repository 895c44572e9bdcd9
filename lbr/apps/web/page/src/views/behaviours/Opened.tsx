// One table: run, watched as a picture of its states and as a sheet, and edited while it runs.
import { useEffect, useMemo, useRef, useState } from "preact/hooks";
import { inWords, told } from "../../access";
import { number, plain } from "../../format";
import { byPage } from "../../handover";
import { status } from "../../live";
import { notice } from "../../notices";
import { Badge, Button, Card, Dialog, Field, Segments } from "../../parts";
import { command, may } from "../../robot";
import { estop } from "../../stopping";
import { t } from "../../words";
import { changeOf, check, COLUMNS, OUTPUT, steps, TABLE, write, type Fault, type Run, type Step, type Summary, type Unmet } from "./data";
import { Export } from "./Files";
import { Graph } from "./Graph";
import { Sheet } from "./Sheet";

const NONE = new Map<number, Unmet[]>();

export function Opened({ owner, of, run, runs, onPick }: { owner: string; of: Summary; run: Run | null; runs: string; onPick: (name: string) => void }) {
  const [rows, setRows] = useState<Step[]>([]);
  const [refused, refuse] = useState<Fault[]>([]);
  const [picked, pick] = useState("");
  const [only, filter] = useState(false);
  const [extra, widen] = useState<{ conditions: string[]; outputs: string[] }>({ conditions: [], outputs: [] });
  const [asked, again] = useState(0);
  const [widening, askColumn] = useState(false);
  const [deleting, askDelete] = useState(false);
  const revision = status.value?.revision;
  const editable = may("admin");
  useEffect(() => {
    let over = false;
    if (may("operate")) void steps(of.name).then((found) => { if (!over && found) setRows(found); });
    return () => { over = true; };
  }, [of.name, revision, asked]);
  const goes = runs !== "";
  const mine = goes && run !== null && (run.table === of.name || run.called.includes(of.name));
  const here = mine && run!.table === of.name;
  const at = here ? run!.state : "";
  const came = useCame(at);
  const unmet = useMemo(() => (here ? new Map(run!.rows.map((one) => [one.step, one.unmet])) : NONE), [here, run]);
  const errors = of.faults.filter((one) => one.error), notes = of.faults.filter((one) => !one.error);
  const state = at || picked || rows.find((row) => row.type === "start")?.state || "";

  /** Tries the rows with one of them changed; keeps it if nothing new is wrong with that row. */
  const keep = async (before: Step | null, after: Step | null): Promise<boolean> => {
    const step = (after ?? before)!.step;
    const next = [...rows.filter((row) => row.step !== step), ...(after ? [after] : [])].sort((a, b) => a.step - b.step);
    if (after) {
      const tried = await check(owner, of.name, next);
      if (!tried.ok) { notice(told(tried), "warn"); return false; }
      const known = new Set(of.faults.map((one) => `${one.step} ${one.column} ${one.text}`));
      const wrong = (tried.data?.faults ?? []).filter((one) => one.error && one.step === step && !known.has(`${one.step} ${one.column} ${one.text}`));
      const cell = wrong.filter((one) => one.column !== COLUMNS.next && one.column !== "");  // a state that is to come may be written before its rows
      refuse(cell);
      if (cell.length > 0) return false;
    }
    return send([changeOf(before, after)], next);
  };
  const send = async (changes: ReturnType<typeof changeOf>[], next: Step[]): Promise<boolean> => {
    const answer = await write(changes);
    if (!answer.ok) {
      notice((answer.data?.problems ?? []).map((one) => `${one.column}: ${one.text}`).join("; ") || told(answer), "warn");
      again(asked + 1);
      return false;
    }
    refuse([]);
    setRows(next);
    notice(t(mine ? "behaviours.kept.running" : "behaviours.kept"), "good");
    return true;
  };
  const swap = (a: Step, b: Step): void => {
    const [first, second] = [{ ...b, step: a.step }, { ...a, step: b.step }];
    void send([changeOf(a, first), changeOf(b, second)], rows.map((row) => (row.step === a.step ? first : row.step === b.step ? second : row)));
  };
  const add = (): void => {
    const step = Math.max(0, ...rows.map((row) => row.step)) + 1;
    void keep(null, { behaviour: of.name, step, type: "", state, conditions: {}, outputs: {}, next_state: state, deadline_s: null });
  };
  const remove = async (): Promise<void> => {
    askDelete(false);
    const table = { table: TABLE, before: { name: of.name }, after: null };
    const answer = await write([...rows.map((row) => changeOf(row, null)), table]);
    if (!answer.ok) notice(told(answer), "warn");
    else onPick("");
  };
  const order = (name: "run" | "pause" | "resume" | "step" | "stop"): void => void command(owner, name, name === "run" ? { name: of.name } : name === "stop" ? { reason: "from the page" } : {});
  const can = may("operate");

  return (
    <div class="behaviours-opened">
      <Card class="behaviours-run">
        <div class="behaviours-title">
          <div><h2>{plain(of.name)}</h2>{of.help && <p class="muted">{of.help}</p>}</div>
          <div class="behaviours-orders">
            {!mine && <Button kind="primary" icon="play" disabled={!can || goes || errors.length > 0 || estop.value.engaged} onClick={() => order("run")}>{t("behaviours.run")}</Button>}
            {mine && run!.phase === "running" && <Button icon="pause" disabled={!can} onClick={() => order("pause")}>{t("behaviours.pause")}</Button>}
            {mine && run!.phase === "paused" && <Button kind="primary" icon="play" disabled={!can} onClick={() => order("resume")}>{t("behaviours.resume")}</Button>}
            {mine && run!.phase === "paused" && <Button icon="ahead" disabled={!can} onClick={() => order("step")}>{t("behaviours.step")}</Button>}
            {mine && <Button icon="close" onClick={() => order("stop")}>{t("behaviours.stop")}</Button>}
          </div>
        </div>
        {goes && !mine && <p class="behaviours-other"><Badge tone="good" icon="play">{t("behaviours.other", { table: plain(runs) })}</Badge><Button kind="quiet" onClick={() => onPick(runs)}>{t("behaviours.show.it")}</Button></p>}
        <Progress run={run} of={of.name} mine={mine} onPick={onPick} />
        <Faults title={t("behaviours.faults.title")} faults={errors} tone="warn" />
        <Faults title={t("behaviours.notes")} faults={notes} tone="calm" />
      </Card>
      {rows.length > 0 && <Graph rows={rows} at={at} came={came} picked={state} onPick={(one) => { pick(one); filter(true); }} />}
      {!can ? <p class="muted">{t("behaviours.rows.role")}</p> : (
        <Card class="behaviours-table">
          <div class="behaviours-tablehead">
            <Segments<"all" | "state">
              label={t("behaviours.which")} value={only ? "state" : "all"} onChange={(value) => filter(value === "state")}
              options={[{ value: "all", text: t("behaviours.all") }, { value: "state", text: t("behaviours.of.state", { state }) }]}
            />
            {editable && <Button icon="plus" onClick={add}>{t("behaviours.add.row")}</Button>}
            {editable && <Button icon="plus" onClick={() => askColumn(true)}>{t("behaviours.add.column")}</Button>}
            <Export owner={owner} name={of.name} />
            {editable && <Button kind="quiet" icon="trash" label={t("behaviours.delete")} disabled={mine} onClick={() => askDelete(true)} />}
          </div>
          <Sheet rows={rows} faults={[...of.faults, ...refused]} at={at} unmet={unmet} picked={state} only={only} editable={editable} extra={extra} onRow={keep} onSwap={swap} />
          {!editable && <p class="muted">{t("behaviours.look")}</p>}
        </Card>
      )}
      <Widen open={widening} onClose={() => askColumn(false)} onColumn={(name) => {
        const out = name.startsWith(OUTPUT);
        widen(out ? { ...extra, outputs: [...extra.outputs, name.slice(OUTPUT.length).trim()] } : { ...extra, conditions: [...extra.conditions, name] });
        filter(false);
      }} />
      <Dialog title={t("behaviours.delete.title", { name: plain(of.name) })} open={deleting} onClose={() => askDelete(false)} actions={<><Button kind="quiet" onClick={() => askDelete(false)}>{t("dialog.cancel")}</Button><Button kind="danger" icon="trash" onClick={() => void remove()}>{t("behaviours.delete")}</Button></>}>
        <p>{t("behaviours.delete.text")}</p>
      </Dialog>
    </div>
  );
}

/** The state that the robot was in before this one. */
function useCame(at: string): string {
  const seen = useRef({ at, came: "" });
  if (seen.current.at !== at) seen.current = { at, came: seen.current.at };
  return seen.current.came;
}

function Progress({ run, of, mine, onPick }: { run: Run | null; of: string; mine: boolean; onPick: (name: string) => void }) {
  if (run === null || run.phase === "resting" || (run.table !== of && !run.called.includes(of))) return null;
  if (run.phase === "ended") {
    if (byPage(run)) return <p><Badge icon="stop">{t("behaviours.ended.stopped", { state: run.state })}</Badge></p>;
    return <p><Badge tone={run.good ? "good" : "warn"} icon={run.good ? "check" : "warn"}>{t(run.good ? "behaviours.ended.good" : "behaviours.ended.bad", { state: run.state, reason: inWords(run) })}</Badge></p>;
  }
  if (!mine) return null;
  const inside = run.table !== of;
  const variables = Object.entries(run.variables).map(([name, value]) => `${name} = ${typeof value === "number" ? number(value, 2) : value}`);
  return (
    <div class="behaviours-progress" aria-live="polite">
      <p>
        {inside && <Button kind="quiet" onClick={() => onPick(run.table)}>{plain(run.table)}</Button>}
        <strong>{run.phase === "paused" ? t("behaviours.paused", { state: run.state }) : t("behaviours.in", { state: run.state, s: number(run.state_s, 1) })}</strong>
        <span class="muted num">{t("behaviours.total", { s: number(run.run_s), count: run.transitions })}</span>
      </p>
      {[run.doing && t("behaviours.doing", { doing: run.doing }), run.result && t("behaviours.result", { result: run.result }), variables.join(", ")].filter(Boolean).map((one) => <p key={one} class="muted">{one}</p>)}
    </div>
  );
}

function Faults({ title, faults, tone }: { title: string; faults: Fault[]; tone: "warn" | "calm" }) {
  if (faults.length === 0) return null;
  return (
    <details class={`behaviours-faults behaviours-faults-${tone}`} open={tone === "warn"}>
      <summary>{title} ({faults.length})</summary>
      <ul>{faults.map((one) => <li key={`${one.step} ${one.column} ${one.text}`}><strong>{where(one)}</strong> {one.text}</li>)}</ul>
    </details>
  );
}

export const where = (one: Fault): string =>
  [one.line > 0 ? t("behaviours.line.of", { line: one.line }) : one.step > 0 ? t("behaviours.row.of", { row: one.step }) : "", one.column].filter(Boolean).join(", ");

function Widen({ open, onClose, onColumn }: { open: boolean; onClose: () => void; onColumn: (name: string) => void }) {
  const [name, type] = useState("");
  const done = (): void => { onColumn(name.trim()); type(""); onClose(); };
  return (
    <Dialog title={t("behaviours.add.column")} open={open} onClose={onClose} actions={<Button kind="primary" icon="plus" disabled={!name.trim().replace(/^O:\s*/, "")} onClick={done}>{t("behaviours.add.column")}</Button>}>
      <Field label={t("behaviours.column")} value={name} maxLength={80} onInput={(event) => type(event.currentTarget.value)} />
      <p class="muted">{t("behaviours.column.hint")}</p>
    </Dialog>
  );
}
