// A form made from a schema: each problem stands beside its field.
import { useState } from "preact/hooks";
import { Button, useOwnId } from "../../parts";
import { plain } from "../../format";
import { t } from "../../words";
import { choiceOf, helpOf, itemTitle, read, same, shown, titleOf, unitOf, type FieldOf, type Problem } from "./schema";

interface FormProps {
  fields: FieldOf[]; value: Record<string, unknown>; path?: string; fixed?: (path: string) => boolean;
  wrong: (path: string) => string; onChange: (value: Record<string, unknown>) => void;
  /** What another has written there since this form was opened; undefined where nothing, or the same. */
  theirs?: Record<string, unknown>;
}

export const said = (problem: Problem | undefined): string => (problem ? t(problem.key, { value: problem.value ?? "" }) : "");

export function Form({ fields, value, path = "", fixed = () => false, wrong, onChange, theirs = {} }: FormProps) {
  const put = (name: string, next: unknown): void => {
    const { [name]: _, ...rest } = value;
    onChange(next === undefined ? rest : { ...value, [name]: next });
  };
  return (
    <div class="form">
      {fields.map((field) => field.kind === "object" ? (
        <fieldset key={field.name} class="form-group">
          <legend>{titleOf(field)}</legend>
          {helpOf(field) && <p class="form-help">{helpOf(field)}</p>}
          {wrong(path + field.name) && <p class="form-wrong" role="alert">{wrong(path + field.name)}</p>}
          <Form fields={field.fields} value={(value[field.name] ?? {}) as Record<string, unknown>} path={`${path}${field.name}.`} fixed={fixed} wrong={wrong} theirs={theirs[field.name] as Record<string, unknown> | undefined} onChange={(next) => put(field.name, Object.keys(next).length > 0 || field.needed || value[field.name] !== undefined ? next : undefined)} />
        </fieldset>
      ) : field.kind === "list" && Array.isArray(value[field.name] ?? field.fallback) ? (
        <List key={field.name} field={field} items={(value[field.name] ?? field.fallback) as Item[]} path={path + field.name} fixed={fixed} wrong={wrong} theirs={theirs[field.name]} onChange={(next) => put(field.name, next)} />
      ) : <One key={field.name} field={field} value={value[field.name]} fixed={fixed(path + field.name)} wrong={wrong(path + field.name)} theirs={theirs[field.name]} onChange={(next) => put(field.name, next)} />)}
    </div>
  );
}

type Item = Record<string, unknown>;
interface ListProps { field: FieldOf; items: Item[]; path: string; fixed: (path: string) => boolean; wrong: (path: string) => string; theirs: unknown; onChange: (items: Item[]) => void }

/** A list of things that have fields: each is folded under its name. */
function List({ field, items, path, fixed, wrong, theirs, onChange }: ListProps) {
  const locked = fixed(path);
  return (
    <fieldset class="form-group">
      <legend>{titleOf(field)}</legend>
      {helpOf(field) && <p class="form-help">{helpOf(field)}</p>}
      {wrong(path) && <p class="form-wrong" role="alert">{wrong(path)}</p>}
      {theirs !== undefined && !same(theirs, items) && <p class="form-theirs" role="status">{t("form.theirs", { value: shown(field, theirs) || "–" })}</p>}
      {items.map((item, number) => (
        <details key={number} class="fold">
          <summary>{itemTitle(field.fields, item, number)}</summary>
          <Form fields={field.fields} value={item} path={`${path}.${number}.`} fixed={fixed} wrong={wrong} onChange={(next) => onChange(items.map((one, at) => (at === number ? next : one)))} />
          {!locked && <div><Button kind="quiet" icon="trash" onClick={() => onChange(items.filter((_, at) => at !== number))}>{t("form.remove")}</Button></div>}
        </details>
      ))}
      {!locked && <div><Button kind="quiet" icon="plus" onClick={() => onChange([...items, {}])}>{t("form.add")}</Button></div>}
    </fieldset>
  );
}

interface OneProps { field: FieldOf; label?: string; value: unknown; fixed: boolean; wrong: string; theirs?: unknown; onChange: (value: unknown) => void }

/** One field, with its unit, its bounds, and what it is where nothing is said. */
export function One({ field, label = titleOf(field), value, fixed, wrong, theirs, onChange }: OneProps) {
  const id = useOwnId();
  const { stem, unit } = unitOf(field);
  const help = helpOf(field);
  const about = { "aria-invalid": wrong !== "", "aria-describedby": wrong || help ? `${id}-about` : undefined, disabled: fixed };
  const usual = field.fallback === null || field.fallback === "" ? "" : shown(field, field.fallback);
  const reaches = [field.least ?? field.above, field.most ?? field.below].some((one) => one !== null) ? `${field.least ?? field.above ?? "…"} – ${field.most ?? field.below ?? "…"}` : "";
  const bounds = [reaches, usual && value !== undefined && !same(value, field.fallback) ? t("form.usual", { value: usual }) : ""].filter(Boolean).join(" · ");
  const [typed, type] = useState<string | null>(null);
  // "0." is 0 as well, and spaces in JSON say nothing: what stands for the value stays as it was typed, or nobody could type on
  const text = typed !== null && same(read(field, typed), value) ? typed : shown(field, value);
  const put = (next: string): void => {
    type(next);
    onChange(read(field, next));
  };
  return (
    <div class={`field form-field ${wrong ? "form-bad" : ""}`}>
      {field.kind === "flag" ? (
        <label class="toggle" for={id}><input id={id} type="checkbox" role="switch" checked={(value ?? field.fallback) === true} onChange={(event) => onChange(event.currentTarget.checked)} {...about} /><span>{label}</span></label>
      ) : (
        <>
          <label class="field-label" for={id}>{label}{unit && <span class="sr"> {plain(field.name.slice(stem.length + 1))}</span>}{bounds && <span class="form-bounds num">{bounds}</span>}</label>
          {field.kind === "choice" ? (
            <select id={id} class="input" value={shown(field, value ?? field.fallback)} onChange={(event) => put(event.currentTarget.value)} {...about}>
              {field.nullable && <option value="">–</option>}
              {field.choices.map((one) => <option key={one} value={one}>{choiceOf(field, one)}</option>)}
            </select>
          ) : field.kind === "json" || field.kind === "list" ? (
            <textarea id={id} class="input form-json" rows={Math.min(8, 1 + Math.ceil(text.length / 48))} value={text} placeholder={usual} spellcheck={false} onInput={(event) => put(event.currentTarget.value)} {...about} />
          ) : (
            <span class="form-number" data-unit={unit || undefined}><input id={id} class="input" inputMode={field.kind === "text" ? "text" : "decimal"} value={text} placeholder={usual} spellcheck={false} autocomplete="off" onInput={(event) => put(event.currentTarget.value)} {...about} />{unit && <span class="form-unit" aria-hidden="true">{unit}</span>}</span>
          )}
        </>
      )}
      {theirs !== undefined && !same(theirs, value) && <p class="form-theirs" role="status">{t("form.theirs", { value: shown(field, theirs) || "–" })}</p>}
      {(wrong || help) && <p id={`${id}-about`} class={wrong ? "form-wrong" : "form-help"}>{wrong || help}</p>}
    </div>
  );
}
