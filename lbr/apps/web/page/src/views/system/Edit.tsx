// One row in a form: tried before it is written; what it touches is told, and what another wrote meanwhile.
import { useEffect, useMemo, useState } from "preact/hooks";
import { told } from "../../access";
import { plain } from "../../format";
import { notice } from "../../notices";
import { Badge, Button, Dialog } from "../../parts";
import { t } from "../../words";
import { drafts, keep } from "./drafts";
import { Form, said } from "./Form";
import { changeAll, nameOf, table as look, type Row, type Table } from "./manage";
import { changes, fieldsOf, kept, problems, same, writtenSince, type FieldOf } from "./schema";
import { effects, heard, useTrial } from "./trial";
import { noteMade } from "./undo";

const OF_ROBOT = ["model", "description", "owner"];

/** By what a draft of a row is kept; a new row has none of its own. */
export const draftOf = (of: Table, row: Row | null): string => `${of.table} ${row ? nameOf(of, row) : ""}`;

export function Edit({ of, row, editable, onClose }: { of: Table; row: Row | null; editable: boolean; onClose: () => void }) {
  const draft = draftOf(of, row);
  const [before, setBefore] = useState<Row | null>(drafts.value[draft]?.before ?? row);
  const [now, edit] = useState<Row>(drafts.value[draft]?.now ?? row ?? {});
  const [sure, beSure] = useState(false);
  const [theirs, setTheirs] = useState<Row>({});
  const fields = useMemo(() => withSettings(fieldsOf(of.schema), of, now), [of, now.name]);
  const local = problems(fields, now);
  const after = changes(before, now);
  const dirty = Object.keys(after).length > 0;
  useEffect(() => keep(drafts, draft, dirty ? { before, now } : null), [before, now]);
  const leave = (): void => {
    keep(drafts, draft, null);
    onClose();
  };
  const [{ reply, refused }, tell] = useTrial([{ table: of.table, before, after }], dirty && local.size === 0 && editable);
  const name = before ? nameOf(of, before) : t("rows.new");
  const mine = (one: { table: string; row: string }): boolean => one.table === of.table && (before === null || one.row === of.key.map((column) => String(before[column])).join("/"));
  const remote = reply?.problems ?? [];
  const wrong = (path: string): string => said(local.get(path)) || remote.filter((one) => mine(one) && one.column === path).map((one) => one.text).join("; ");
  const elsewhere = remote.filter((one) => !mine(one) || !fields.some((field) => field.name === one.column));
  const touched = reply?.accepted ? reply.touched : null;
  const send = async (next: Row | null): Promise<void> => {
    const one = { table: of.table, before, after: next };
    const answer = await changeAll([one], true, true);
    if (answer.ok) {
      const called = before ? name : String(next?.[of.key[0] ?? ""] ?? "");
      noteMade(t(next === null ? "rows.deleted" : "rows.saved", { name: plain(called) }), plain(called), answer);
      leave();
      return;
    }
    tell(heard(answer));
  };
  const reload = async (keep: boolean): Promise<void> => {
    const answer = await look(of.table);
    if (!answer.ok) { tell({ reply, refused: told(answer) }); return; }
    const there = answer.data?.data?.rows.find((one) => before !== null && of.key.every((column) => same(one[column], before[column])));
    if (!there && !keep) { notice(t("rows.deleted", { name }), "warn"); leave(); return; }
    if (!there) { setTheirs({}); setBefore(null); return; }
    edit(keep ? kept(there, before!, after) : there);
    setTheirs(keep ? writtenSince(before!, there) : {});
    setBefore(there);
  };
  const fixed = (path: string): boolean => !editable || (before !== null && of.key.includes(path)) || (of.table === "robot" && !OF_ROBOT.includes(path));
  const form = (shown: FieldOf[]) => <Form fields={shown} value={now} wrong={wrong} theirs={theirs} fixed={fixed} onChange={edit} />;
  const [own, others] = [fields.filter((one) => one.kind === "object"), fields.filter((one) => one.kind !== "object")];
  const deletes = editable && before !== null && of.table !== "robot";
  return (
    <Dialog
      title={own.length > 0 ? plain(name) : `${plain(of.table)}: ${name}`} open onClose={onClose}
      actions={editable ? (
        <>
          <Button kind="quiet" onClick={leave}>{t("dialog.cancel")}</Button>
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
          : touched ? <p>{effects(touched)}</p>
            : editable ? <p class="muted">{local.size + remote.length > 0 && dirty ? t("rows.mend") : dirty ? t("rows.trying") : t("rows.hint")}</p> : <p class="muted">{of.fixed || t("rows.look")}</p>}
      </div>
      {own.length > 0 && before !== null ? (
        <>
          {form(own)}
          <Fold title={t("rows.more")} opened={others.some((one) => wrong(one.name) !== "")}>{form(others)}</Fold>
        </>
      ) : form(fields)}
      {deletes && <Fold title={t("rows.delete")}><p class="muted">{t("rows.delete.text")}</p><div><Button kind="danger" icon="trash" onClick={() => (sure ? void send(null) : beSure(true))}>{t(sure ? "rows.sure" : "rows.delete")}</Button></div></Fold>}
    </Dialog>
  );
}

/** What few ask for, under its name; what is wrong within is never hidden. */
export function Fold({ title, opened = false, children }: { title: string; opened?: boolean; children: preact.ComponentChildren }) {
  const [open, unfold] = useState(false);
  return <details class="fold" open={open || opened} onToggle={(event) => unfold(event.currentTarget.open)}><summary>{title}</summary>{children}</details>;
}

/** The column `settings` as the fields of its kind, where they are known: those that people ask for first. */
function withSettings(fields: FieldOf[], of: Table, row: Row): FieldOf[] {
  const schema = of.settings[String(row["name"] ?? "")];
  if (!schema) return fields.map((field) => (typeof row[field.name] === "object" && field.kind === "text" ? { ...field, kind: "json" } : field));
  const own = fieldsOf(schema);
  return fields.map((field) => (field.name === "settings" ? { ...field, title: t("rows.settings"), help: "", kind: "object", needed: true, fields: [...own.filter((one) => one.basic), ...own.filter((one) => !one.basic)] } : field));
}
