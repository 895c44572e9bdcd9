// What the robot is set to: what people ask for first, then every part by itself, and the way back.
import { useEffect, useState } from "preact/hooks";
import { told } from "../../access";
import { number, percent, plain } from "../../format";
import { status } from "../../live";
import { Badge, Button, Card, Icon, Slider, type IconName } from "../../parts";
import { may, robot } from "../../robot";
import { PREFIX } from "../../stream";
import { maybe, named, t } from "../../words";
import { basicsOf, groupsOf, isShare, valueAt, withValue, type Basic, type Path, type Settings as Values } from "./basics";
import { keep, typed, type Typed } from "./drafts";
import { One, said } from "./Form";
import { changeAll, table as look, type Row, type RowChange, type Table } from "./manage";
import { Rows } from "./Rows";
import { fieldsOf, helpOf, same, wrong as wrongOf, type FieldOf } from "./schema";
import { effects, useTrial } from "./trial";
import { made, noteMade, undo } from "./undo";

const AGAIN_MS = 2000;
const NAMES = ["model", "description", "owner"];
const ICONS: Record<string, IconName> = { speed: "speed", distances: "radar", voice: "speak", cameras: "camera", joints: "joints", calls: "phone", name: "person" };

export function Settings() {
  return (
    <div class="stack">
      <Saved />
      {may("operate") && <Basics />}
      <h3>{t("settings.all")}</h3>
      <Rows />
    </div>
  );
}

/** What was saved last, with its way back beside it. */
function Saved() {
  const [busy, wait] = useState(false);
  const newest = made.value.at(-1);
  return (
    <div class="settings-saved" role="status" data-there={newest !== undefined || undefined}>
      {newest && (
        <>
          <Icon name="check" /><p>{newest.said}</p>
          <Button kind="quiet" icon="undo" disabled={busy} onClick={() => { wait(true); void undo().finally(() => wait(false)); }}>{t("rows.undo")}</Button>
        </>
      )}
    </div>
  );
}

interface Part { row: Row; fields: FieldOf[] }
const keyOf = (part: string, path: Path): string => [part, ...path].join("/");

function Basics() {
  const [capabilities, setCapabilities] = useState<Table | null>(null);
  const [robots, setRobots] = useState<Table | null>(null);
  const [asked, again] = useState(0);
  const revision = status.value?.revision;
  useEffect(() => {
    let over = false, timer: ReturnType<typeof setTimeout> | undefined;
    const ask = (): void => void Promise.all([look("capability"), look("robot")]).then(([found, own]) => {
      if (over) return;
      if (!found.ok || !own.ok) { timer = setTimeout(ask, AGAIN_MS); return; }
      setCapabilities(found.data?.data ?? null);
      setRobots(own.data?.data ?? null);
    });
    ask();
    return () => { over = true; clearTimeout(timer); };
  }, [revision, asked]);
  const parts = new Map<string, Part>((capabilities?.rows ?? []).flatMap((row) => {
    const schema = capabilities!.settings[String(row["name"])];
    return schema && row["enabled"] !== false ? [[String(row["name"]), { row, fields: fieldsOf(schema) }] as const] : [];
  }));
  const own = robots?.rows[0];
  const names: Basic[] = robots && own ? fieldsOf(robots.schema).filter((one) => NAMES.includes(one.name)).map((field) => ({ part: "", path: [field.name], group: "name", title: maybe(`settings.of.${field.name}`) || plain(field.name), field: { ...field, help: "" } })) : [];
  const groups = [...groupsOf([...parts].flatMap(([name, { row, fields }]) => basicsOf(name, fields, row["settings"] as Values))), ...(names.length > 0 ? [{ group: "name", basics: names }] : [])];
  const editable = may("admin");
  const written = ({ part, path }: Basic): unknown => (part === "" ? own?.[String(path[0])] : valueAt(parts.get(part)?.fields ?? [], parts.get(part)?.row["settings"], path));
  const there = ({ part }: Basic): boolean => (part === "" ? own !== undefined : parts.has(part)); // what is kept may be older than what is read
  const all = Object.values(typed.value).filter(({ basic, value }) => there(basic) && !same(value, written(basic)));
  const local = all.filter(({ basic, value }) => wrongOf(basic.field, value) !== null);
  const changes = changesOf(all, parts, own);
  const dirty = all.length > 0;
  const [{ reply, refused }, tell] = useTrial(changes, dirty && local.length === 0);
  const save = async (): Promise<void> => {
    const answer = await changeAll(changes, true, true);
    again(asked + 1);
    if (!answer.ok) { tell({ reply: answer.data, refused: told(answer) }); return; }
    const name = [...new Set(all.map(({ basic }) => basic.title))].join(", ");
    noteMade(t("rows.saved", { name }), name, answer);
    setCapabilities((known) => known && after(known, changes));
    setRobots((known) => known && after(known, changes));
    typed.value = {};
  };
  const field = (basic: Basic) => {
    const key = keyOf(basic.part, basic.path);
    const value = key in typed.value ? typed.value[key]!.value : written(basic);
    const put = (next: unknown): void => keep(typed, key, same(next, written(basic)) ? null : { basic, value: next });
    const problem = said(wrongOf(basic.field, value) ?? undefined);
    if (!isShare(basic.field)) return <One key={key} field={basic.field} label={basic.title} value={value} fixed={!editable} wrong={problem} onChange={put} />;
    const usual = basic.field.fallback;
    return (
      <div key={key} class="settings-share">
        <Slider label={basic.title} min={basic.field.least ?? 0.05} max={1} step={0.05} value={Number(value)} show={(share) => shown(basic, share)} disabled={!editable} onInput={put} />
        <p class="form-help">{[helpOf(basic.field), typeof usual === "number" && usual !== value ? t("form.usual", { value: percent(usual) }) : ""].filter(Boolean).join(" · ")}</p>
      </div>
    );
  };
  if (groups.length === 0) return <p class="muted">{t("rows.wait")}</p>;
  return (
    <>
      <div class="settings-groups">
        {groups.map(({ group, basics }) => {
          const of = [...new Set(basics.map((one) => one.part))];
          return (
            <Card key={group} title={maybe(`settings.${group}`) || plain(group)} icon={ICONS[group] ?? "settings"}>
              {of.map((part) => (
                <div key={part} class="form">
                  {of.length > 1 && <h4>{named(part.replace(PREFIX, ""))}</h4>}
                  {basics.filter((one) => one.part === part).map(field)}
                </div>
              ))}
            </Card>
          );
        })}
      </div>
      {dirty && (
        <div class="settings-foot">
          <div aria-live="polite">
            {refused || reply?.reason ? <Badge tone="warn" icon="warn">{refused || reply?.reason}</Badge> : local.length > 0 ? <p class="muted">{t("rows.mend")}</p> : reply?.accepted && reply.touched ? <p>{effects(reply.touched)}</p> : <p class="muted">{t("rows.trying")}</p>}
          </div>
          <Button kind="quiet" onClick={() => { typed.value = {}; }}>{t("dialog.cancel")}</Button>
          <Button kind="primary" icon="save" disabled={!editable || local.length > 0 || (reply !== null && !reply.accepted)} onClick={() => void save()}>{t("rows.save")}</Button>
        </div>
      )}
    </>
  );
}

/** A share of full power; of a base that knows its own speed the speed, too, as the slider beside the stick shows it. */
function shown({ part, path }: Basic, share: number): string {
  const base = robot.value?.base;
  const most = base && base.capability === part && path.join("/") === "max_power" && base.max_power ? base.max_speed_mps / base.max_power : 0;
  return [percent(share), most ? `${number(share * most, 2)} m/s` : ""].filter(Boolean).join(" · ");
}

/** What was typed, as one change for each row: only what was typed is another. */
function changesOf(wanted: Typed[], parts: Map<string, Part>, own: Row | undefined): RowChange[] {
  const found = new Map<string, RowChange>();
  for (const { basic: { part, path }, value } of wanted) {
    if (part === "") {
      const column = String(path[0]);
      const known = found.get(part) ?? { table: "robot", before: { name: own?.["name"] }, after: {} };
      found.set(part, { ...known, before: { ...known.before, [column]: own?.[column] }, after: { ...known.after, [column]: value ?? "" } });
      continue;
    }
    const { row, fields } = parts.get(part) ?? {};
    if (!row || !fields) continue;
    const known = found.get(part)?.after?.["settings"] ?? row["settings"];
    found.set(part, { table: "capability", before: { name: part, settings: row["settings"] }, after: { settings: withValue(fields, known, path, value) } });
  }
  return [...found.values()];
}

/** A table after some changes of it, until the robot tells of it again. */
const after = (of: Table, changes: RowChange[]): Table =>
  ({ ...of, rows: of.rows.map((row) => ({ ...row, ...changes.find((one) => one.table === of.table && one.before?.["name"] === row["name"])?.after })) });
