// Tables from files and back: picked or dropped, looked at with every fault by its line, and only then taken.
import { useEffect, useRef, useState } from "preact/hooks";
import { told } from "../../access";
import { plain } from "../../format";
import { notice } from "../../notices";
import { Badge, Button, Choice, Dialog, Field } from "../../parts";
import { bytesOf, save } from "../../saving";
import { t } from "../../words";
import type { Row } from "../system/manage";
import { exchange, first, LARGEST, MOST_CHANGES, nameFrom, read, steps, TABLE, write, written, type Fault, type Step, type Summary, typed } from "./data";
import { where } from "./Opened";

interface Taken { file: string; content: string; rows: Step[]; faults: Fault[] }

/** Makes a table of rows, in the place of the one that has its name, if there is one. */
async function keep(name: string, help: string, rows: Step[], tables: Summary[]): Promise<boolean> {
  const there = tables.find((one) => one.name === name);
  const old = there ? await steps(name) : [];
  if (old === null) return false;
  const table = { table: TABLE, before: there ? ({ name } as Row) : null, after: { name, ...(help || !there ? { help } : {}) } as Row };
  const changes = [...(there && !help ? [] : [table]), ...exchange(old, rows)];
  if (changes.length > MOST_CHANGES) { notice(t("behaviours.too.large"), "warn"); return false; }
  if (changes.length === 0) return true;
  const answer = await write(changes);
  if (!answer.ok) notice((answer.data?.problems ?? []).map((one) => `${one.row}, ${one.column}: ${one.text}`).join("; ") || told(answer), "warn");
  return answer.ok;
}

export function Import({ owner, tables, onTaken }: { owner: string; tables: Summary[]; onTaken: (name: string) => void }) {
  const input = useRef<HTMLInputElement>(null);
  const [taken, take] = useState<Taken | null>(null);
  const [name, call] = useState("");
  const look = async (file: File | undefined): Promise<void> => {
    if (!file) return;
    if (file.size > LARGEST) return notice(t("behaviours.too.large"), "warn");
    const bytes = new Uint8Array(await file.arrayBuffer());
    const content = btoa(Array.from(bytes, (one) => String.fromCharCode(one)).join(""));
    const first = nameFrom(file.name);
    const answer = await read(owner, first, file.name, content);
    if (!answer.ok || !answer.data) return notice(told(answer), "warn");
    call(first);
    take({ file: file.name, content, rows: answer.data.rows, faults: answer.data.faults });
  };
  useEffect(() => {
    const over = (event: DragEvent): void => { if (event.dataTransfer?.types.includes("Files")) event.preventDefault(); };
    const drop = (event: DragEvent): void => { event.preventDefault(); void look(event.dataTransfer?.files[0]); };
    document.addEventListener("dragover", over);
    document.addEventListener("drop", drop);
    return () => { document.removeEventListener("dragover", over); document.removeEventListener("drop", drop); };
  });
  const called = nameFrom(name);
  const errors = taken?.faults.filter((one) => one.error) ?? [];
  const done = async (): Promise<void> => {
    const answer = await read(owner, called, taken!.file, taken!.content);  // the rows bear the name of their table
    if (!answer.ok || !answer.data) return notice(told(answer), "warn");
    if (!(await keep(called, "", answer.data.rows, tables))) return;
    notice(t("behaviours.import.taken", { name: plain(called), count: answer.data.rows.length }), "good");
    take(null);
    onTaken(called);
  };
  return (
    <>
      <Button icon="down" onClick={() => input.current?.click()}>{t("behaviours.import")}</Button>
      <p class="muted behaviours-drop">{t("behaviours.import.drop")}</p>
      <input ref={input} type="file" hidden accept=".csv,.json,.txt,text/csv,application/json" aria-label={t("behaviours.import")} onChange={(event) => { void look(event.currentTarget.files?.[0]); event.currentTarget.value = ""; }} />
      <Dialog
        title={t("behaviours.import.title", { file: taken?.file ?? "" })} open={taken !== null} onClose={() => take(null)}
        actions={<><Button kind="quiet" onClick={() => take(null)}>{t("dialog.cancel")}</Button><Button kind="primary" icon="check" disabled={!name || errors.length > 0 || !taken?.rows.length} onClick={() => void done()}>{tables.some((one) => one.name === called) ? t("behaviours.import.replace", { name: plain(called) }) : t("behaviours.import.take")}</Button></>}
      >
        <Field label={t("behaviours.name")} value={name} maxLength={40} onInput={(event) => call(typed(event.currentTarget.value))} />
        <p><Badge tone={errors.length > 0 ? "warn" : "good"} icon={errors.length > 0 ? "warn" : "check"}>{errors.length > 0 ? t("behaviours.faults", { count: errors.length }) : t("behaviours.import.rows", { count: taken?.rows.length ?? 0 })}</Badge></p>
        {taken && taken.faults.length > 0 && <ul class="behaviours-found">{[...errors, ...taken.faults.filter((one) => !one.error)].map((one) => <li key={`${one.line} ${one.column} ${one.text}`} class={one.error ? "form-wrong" : "muted"}><strong>{where(one)}</strong> {one.text}</li>)}</ul>}
      </Dialog>
    </>
  );
}

export function New({ tables, onMade }: { tables: Summary[]; onMade: (name: string) => void }) {
  const [open, show] = useState(false);
  const [name, call] = useState("");
  const [help, say] = useState("");
  const called = nameFrom(name);
  const there = name !== "" && tables.some((one) => one.name === called);
  const make = async (): Promise<void> => {
    if (!(await keep(called, help, first(called), tables))) return;
    show(false);
    onMade(called);
  };
  return (
    <>
      <Button icon="plus" onClick={() => show(true)}>{t("behaviours.new")}</Button>
      <Dialog title={t("behaviours.new")} open={open} onClose={() => show(false)} actions={<Button kind="primary" icon="plus" disabled={name === "" || there} onClick={() => void make()}>{t("behaviours.make")}</Button>}>
        <Field label={t("behaviours.name")} value={name} maxLength={40} placeholder="my_patrol" aria-invalid={there} onInput={(event) => call(typed(event.currentTarget.value))} />
        {there && <p class="form-wrong" role="alert">{t("behaviours.name.there", { name: plain(called) })}</p>}
        <Field label={t("behaviours.help")} value={help} maxLength={200} onInput={(event) => say(event.currentTarget.value)} />
      </Dialog>
    </>
  );
}

export function Export({ owner, name }: { owner: string; name: string }) {
  const forms = ["csv", "semicolons", "json"] as const;
  const out = async (form: string): Promise<void> => {
    const answer = await written(owner, name, form);
    if (!answer.ok || !answer.data) return notice(told(answer), "warn");
    save(`${name}.${form === "json" ? "json" : "csv"}`, bytesOf(answer.data.content));
  };
  return <Choice label={t("behaviours.export")} value="" options={[{ value: "", text: `${t("behaviours.export")} …` }, ...forms.map((one) => ({ value: one, text: t(`behaviours.export.${one}`) }))]} onChange={(form) => { if (form) void out(form); }} />;
}
