// The rows that the robot is made of: looked at, changed in forms, tried before they are written.
import { useEffect, useMemo, useRef, useState } from "preact/hooks";
import { plain } from "../../format";
import { remember, remembered } from "../../kept";
import { status } from "../../live";
import { notice } from "../../notices";
import { Badge, Button, Choice, Dialog, Empty, Field } from "../../parts";
import { told } from "../../access";
import { may } from "../../robot";
import { t } from "../../words";
import { Form, said } from "./Form";
import { change, nameOf, table as look, tables, type Reply, type Row, type Table, type TableOf } from "./manage";
import { changes, fieldsOf, kept, problems, same, writtenSince, type FieldOf } from "./schema";

const TRY_MS = 400;
const AGAIN_MS = 2000;
const MOST_SHOWN = 200;

export function Rows() {
  const [all, setAll] = useState<TableOf[]>([]);
  const [name, choose] = useState<string>(remembered("rows", "capability"));
  const [found, setFound] = useState<Table | null>(null);
  const [wanted, find] = useState("");
  const [opened, open] = useState<Row | "new" | null>(null);
  const [asked, again] = useState(0);
  const revision = status.value?.revision;
  useEffect(() => { void tables().then((answer) => setAll(answer.data?.data?.tables ?? [])); }, [revision]);
  useEffect(() => {
    let over = false, timer: ReturnType<typeof setTimeout> | undefined;
    const ask = (): void => void look(name).then((answer) => {
      if (over) return;
      setFound(answer.ok ? answer.data?.data ?? null : null);
      if (!answer.ok) timer = setTimeout(ask, AGAIN_MS);
    });
    ask();
    return () => { over = true; clearTimeout(timer); };
  }, [name, revision, asked]);
  if (!may("operate")) return <Empty icon="lock" title={t("rows.role")} />;
  const editable = found !== null && !found.fixed && may("admin");
  const shown = (found?.rows ?? []).filter((row) => JSON.stringify(row).toLowerCase().includes(wanted.trim().toLowerCase())).slice(0, MOST_SHOWN);
  return (
    <div class="stack">
      <div class="system-tools">
        <Choice label={t("rows.table")} value={name} options={(all.length > 0 ? all : [{ table: name, rows: 0 }]).map((one) => ({ value: one.table, text: `${plain(one.table)} (${one.rows})` }))} onChange={(next) => { if (next !== name) setFound(null); choose(next); remember("rows", next); }} />
        {editable && found.table !== "robot" && <Button icon="plus" onClick={() => open("new")}>{t("rows.add")}</Button>}
        <div class="system-find"><Field label={t("rows.find")} type="search" value={wanted} onInput={(event) => find(event.currentTarget.value)} /></div>
      </div>
      {found?.fixed && <p class="muted">{found.fixed}</p>}
      {found === null ? <p class="muted">{t("rows.wait")}</p> : shown.length === 0 ? <Empty icon="search" title={t("rows.none")} /> : (
        <ul class="rows">
          {shown.map((row) => (
            <li key={nameOf(found, row)}>
              <button type="button" class="row" onClick={() => open(row)}>
                <strong>{nameOf(found, row)}</strong>
                <span class="muted">{summary(found, row)}</span>
              </button>
            </li>
          ))}
        </ul>
      )}
      {found && opened && <Edit key={opened === "new" ? "new" : nameOf(found, opened)} of={found} row={opened === "new" ? null : opened} editable={editable} onClose={() => { open(null); again(asked + 1); }} />}
    </div>
  );
}

function summary(of: Table, row: Row): string {
  if (typeof row["help"] === "string" && row["help"]) return [row["enabled"] === false ? t("system.off") : "", row["kind"], row["help"]].filter(Boolean).join(" · ");
  const told = Object.entries(row).filter(([column, value]) => !of.key.includes(column) && value !== null && value !== "" && !same(value, {}) && !same(value, []));
  return told.map(([column, value]) => `${plain(column)} ${typeof value === "string" ? value : JSON.stringify(value)}`).join(" · ").slice(0, 220);
}

function Edit({ of, row, editable, onClose }: { of: Table; row: Row | null; editable: boolean; onClose: () => void }) {
  const [before, setBefore] = useState<Row | null>(row);
  const [now, edit] = useState<Row>(row ?? {});
  const [reply, setReply] = useState<Reply<null> | null>(null);
  const [refused, refuse] = useState("");
  const [sure, beSure] = useState(false);
  const [theirs, setTheirs] = useState<Row>({});
  const asked = useRef(0);
  const fields = useMemo(() => withSettings(fieldsOf(of.schema), of, now), [of, now.name]);
  const local = problems(fields, now);
  const after = changes(before, now);
  const dirty = Object.keys(after).length > 0;
  useEffect(() => {
    setReply(null);
    refuse("");
    if (!dirty || local.size > 0 || !editable) return;
    const mine = ++asked.current;
    const timer = setTimeout(() => void change({ table: of.table, before, after }, false).then((answer) => {
      if (mine !== asked.current) return;
      setReply(answer.data);
      refuse(answer.ok || (answer.data?.problems ?? []).length > 0 ? "" : told(answer));
    }), TRY_MS);
    return () => clearTimeout(timer);
  }, [JSON.stringify(after), before]);
  const name = before ? nameOf(of, before) : t("rows.new");
  const mine = (one: { table: string; row: string }): boolean => one.table === of.table && (before === null || one.row === of.key.map((column) => String(before[column])).join("/"));
  const remote = reply?.problems ?? [];
  const wrong = (path: string): string => said(local.get(path)) || remote.filter((one) => mine(one) && one.column === path).map((one) => one.text).join("; ");
  const elsewhere = remote.filter((one) => !mine(one) || !fields.some((field) => field.name === one.column));
  const touched = reply?.accepted ? reply.touched : null;
  const effects = touched ? (["restart", "start", "stop", "plug"] as const).filter((what) => touched[what].length > 0) : [];
  const send = async (next: Row | null): Promise<void> => {
    const answer = await change({ table: of.table, before, after: next }, true);
    if (answer.ok) {
      notice(t(next === null ? "rows.deleted" : "rows.saved", { name: before ? name : String(next?.[of.key[0] ?? ""] ?? "") }), "good");
      onClose();
      return;
    }
    setReply(answer.data);
    refuse((answer.data?.problems ?? []).length > 0 ? "" : told(answer));
  };
  const reload = async (keep: boolean): Promise<void> => {
    const answer = await look(of.table);
    if (!answer.ok) { refuse(told(answer)); return; }
    const there = answer.data?.data?.rows.find((one) => before !== null && of.key.every((column) => same(one[column], before[column])));
    if (!there && !keep) { notice(t("rows.deleted", { name }), "warn"); onClose(); return; }
    if (!there) { setTheirs({}); setBefore(null); return; }
    edit(keep ? kept(there, before!, after) : there);
    setTheirs(keep ? writtenSince(before!, there) : {});
    setBefore(there);
  };
  return (
    <Dialog
      title={`${plain(of.table)}: ${name}`} open onClose={onClose}
      actions={editable ? (
        <>
          {before && of.table !== "robot" && <Button kind="danger" icon="trash" class="rows-delete" onClick={() => (sure ? void send(null) : beSure(true))}>{t(sure ? "rows.sure" : "rows.delete")}</Button>}
          <Button kind="quiet" onClick={onClose}>{t("dialog.cancel")}</Button>
          <Button kind="primary" icon="save" disabled={!dirty || local.size > 0 || remote.length > 0} onClick={() => void send(after)}>{t("rows.save")}</Button>
        </>
      ) : undefined}
    >
      <div class="rows-preview" aria-live="polite">
        {refused ? (
          <>
            <Badge tone="warn" icon="warn">{refused}</Badge>
            {before && <div class="system-tools"><Button onClick={() => void reload(false)}>{t("rows.theirs")}</Button><Button onClick={() => void reload(true)}>{t("rows.mine")}</Button></div>}
          </>
        ) : elsewhere.length > 0 ? elsewhere.map((one) => <p key={one.table + one.row + one.column} class="form-wrong">{`${plain(one.table)} ${one.row}, ${one.column}: ${one.text}`}</p>)
          : touched ? <p>{effects.length === 0 ? t("rows.nothing") : effects.map((what) => t(`rows.${what}`, { names: touched[what].map(plain).join(", ") })).join(" ")}</p>
            : editable ? <p class="muted">{local.size + remote.length > 0 && dirty ? t("rows.mend") : dirty ? t("rows.trying") : t("rows.hint")}</p> : <p class="muted">{of.fixed || t("rows.look")}</p>}
      </div>
      <Form fields={fields} value={now} wrong={wrong} theirs={theirs} fixed={(path) => !editable || (before !== null && of.key.includes(path)) || (of.table === "robot" && !["model", "description", "owner"].includes(path))} onChange={edit} />
    </Dialog>
  );
}

/** The column `settings` as the fields of its kind, where they are known. */
function withSettings(fields: FieldOf[], of: Table, row: Row): FieldOf[] {
  const schema = of.settings[String(row["name"] ?? "")];
  if (!schema) return fields.map((field) => (typeof row[field.name] === "object" && field.kind === "text" ? { ...field, kind: "json" } : field));
  return fields.map((field) => (field.name === "settings" ? { ...field, kind: "object", needed: true, fields: fieldsOf(schema) } : field));
}
