// The rows that the robot is made of: of each table a list, each row in a form.
import { useEffect, useState } from "preact/hooks";
import { plain } from "../../format";
import { remember, remembered } from "../../kept";
import { status } from "../../live";
import { Badge, Button, Choice, Empty, Field } from "../../parts";
import { may } from "../../robot";
import { t } from "../../words";
import { drafts } from "./drafts";
import { draftOf, Edit } from "./Edit";
import { nameOf, table as look, tables, type Row, type Table, type TableOf } from "./manage";
import { same } from "./schema";

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
      if (answer.ok) setFound(answer.data?.data ?? null);
      else timer = setTimeout(ask, AGAIN_MS); // what is known stays, and a form that is open with it
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
                <strong>{found.table === "capability" ? plain(nameOf(found, row)) : nameOf(found, row)}</strong>
                <span class="muted">{summary(found, row)}</span>
                {draftOf(found, row) in drafts.value && <Badge tone="warn" icon="edit">{t("rows.draft")}</Badge>}
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
