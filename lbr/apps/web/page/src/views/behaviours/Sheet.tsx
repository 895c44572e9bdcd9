// A table as a sheet: cells are typed in place, each problem stands below its cell, and while it runs what is measured does too.
import { useEffect, useRef, useState } from "preact/hooks";
import { number } from "../../format";
import { Button, Choice } from "../../parts";
import { t } from "../../words";
import { COLUMNS, headings, OUTPUT, TYPES, type Fault, type Step, type Unmet } from "./data";

const LONGEST_STATE = 80, LONGEST_CELL = 300; // characters, as the robot takes them

interface SheetProps {
  rows: Step[]; faults: Fault[]; at: string; unmet: Map<number, Unmet[]>; picked: string; only: boolean; editable: boolean;
  extra: { conditions: string[]; outputs: string[] };
  /** Keeps a row as it is to be; says whether it was kept. */
  onRow: (before: Step, after: Step | null) => Promise<boolean>;
  onSwap: (a: Step, b: Step) => void;
}

export function Sheet({ rows, faults, at, unmet, picked, only, editable, extra, onRow, onSwap }: SheetProps) {
  const conditions = [...new Set([...headings(rows, "conditions"), ...extra.conditions])];
  const outputs = [...new Set([...headings(rows, "outputs"), ...extra.outputs])];
  const timed = rows.some((row) => row.deadline_s !== null);
  const shown = only ? rows.filter((row) => row.state === picked) : rows;
  const states = [...new Set(rows.map((row) => row.state).filter(Boolean))];
  return (
    <div class="behaviours-sheet" tabIndex={0} role="group" aria-label={t("behaviours.rows")}>
      <datalist id="behaviours-states">{states.map((one) => <option key={one} value={one} />)}</datalist>
      <table>
        <thead>
          <tr>
            <th scope="col" class="num">#</th>
            <th scope="col">{t("behaviours.state")}</th>
            {conditions.map((one) => <th key={one} scope="col">{one}</th>)}
            {outputs.map((one) => <th key={`O:${one}`} scope="col" class="behaviours-out">{one}</th>)}
            <th scope="col">{t("behaviours.next")}</th>
            {timed && <th scope="col">{t("behaviours.deadline")}</th>}
            <th scope="col">{t("behaviours.type")}</th>
            {editable && <th scope="col"><span class="behaviours-hidden">{t("behaviours.row")}</span></th>}
          </tr>
        </thead>
        <tbody>
          {shown.map((row, index) => {
            const live = row.state === at ? unmet.get(row.step) : undefined;
            const wrong = (column: string): string => faults.filter((one) => one.step === row.step && one.column === column).map((one) => one.text).join("; ");
            const put = (part: Partial<Step>): Promise<boolean> => onRow(row, { ...row, ...part });
            const cells = (which: "conditions" | "outputs", column: string, text: string): Promise<boolean> => {
              const { [column]: _, ...rest } = row[which];
              return put({ [which]: text.trim() === "" ? rest : { ...row[which], [column]: text } });
            };
            const before = shown[index - 1];
            const cell = { editable, row: row.step };
            return (
              <tr key={row.step} class={`${row.state === at ? "behaviours-row-at" : ""} ${row.type === "#" ? "behaviours-comment" : ""}`}>
                <td class="num behaviours-number">{row.step}{wrong("") && <p class="form-wrong">{wrong("")}</p>}</td>
                <Cell {...cell} name={COLUMNS.state} value={row.state} list="behaviours-states" longest={LONGEST_STATE} wrong={wrong(COLUMNS.state)} onKeep={(state) => put({ state })} />
                {conditions.map((one) => (
                  <Cell key={one} {...cell} name={one} value={row.conditions[one] ?? ""} wrong={wrong(one)} live={live && (row.conditions[one] ?? "") !== "" ? live.find((miss) => miss.column === one) ?? true : undefined} onKeep={(text) => cells("conditions", one, text)} />
                ))}
                {outputs.map((one) => (
                  <Cell key={`O:${one}`} {...cell} name={OUTPUT + one} value={row.outputs[one] ?? ""} wrong={wrong(OUTPUT + one)} onKeep={(text) => cells("outputs", one, text)} />
                ))}
                <Cell {...cell} name={COLUMNS.next} value={row.next_state} list="behaviours-states" longest={LONGEST_STATE} wrong={wrong(COLUMNS.next)} onKeep={(next_state) => put({ next_state })} />
                {timed && <Cell {...cell} name={COLUMNS.deadline} value={row.deadline_s === null ? "" : String(row.deadline_s)} wrong={wrong(COLUMNS.deadline)} onKeep={(text) => put({ deadline_s: text.trim() === "" ? null : Number(text.replace(",", ".")) })} />}
                <td class="behaviours-type">
                  {editable ? <Choice label={t("behaviours.cell", { column: COLUMNS.type, row: row.step })} value={row.type} options={TYPES.map((one) => ({ value: one, text: one === "" ? "–" : one }))} onChange={(type) => void put({ type })} /> : row.type}
                  {wrong(COLUMNS.type) && <p class="form-wrong">{wrong(COLUMNS.type)}</p>}
                </td>
                {editable && (
                  <td class="behaviours-tools">
                    <Button kind="quiet" icon="up" disabled={!before} label={t("behaviours.up", { row: row.step })} onClick={() => before && onSwap(before, row)} />
                    <Button kind="quiet" icon="trash" label={t("behaviours.remove", { row: row.step })} onClick={() => void onRow(row, null)} />
                  </td>
                )}
              </tr>
            );
          })}
        </tbody>
      </table>
    </div>
  );
}

interface CellProps { name: string; row: number; value: string; wrong: string; editable: boolean; list?: string; longest?: number; live?: Unmet | true; onKeep: (text: string) => Promise<boolean> }

/** What is typed is kept on Enter or on leaving the cell; what was refused stays to be mended, Escape takes it back. */
function Cell({ name, row, value, wrong, editable, list, longest = LONGEST_CELL, live, onKeep }: CellProps) {
  const [typed, type] = useState<string | null>(null);
  const why = useRef("");
  why.current = typed === null ? "" : wrong || why.current;  // stays with a text that is not kept, whatever is kept elsewhere
  const bad = wrong || why.current;
  const box = useRef<HTMLInputElement>(null);
  useEffect(() => type(null), [value]);
  const keep = async (): Promise<void> => {
    if (typed === null || typed === value) return type(null);
    if (await onKeep(typed)) type(null);
  };
  const missed = live !== undefined && live !== true;
  const text = typed ?? value;
  return (
    <td class={`${bad ? "form-bad" : ""} ${live === undefined ? "" : missed ? "behaviours-unmet" : "behaviours-met"}`}>
      {editable ? (
        <input
          ref={box} class="input behaviours-cell" value={text} list={list} maxLength={longest} spellcheck={false} autocomplete="off" aria-invalid={bad !== ""} aria-label={t("behaviours.cell", { column: name, row })}
          style={{ width: `${Math.max(6, Math.min(24, text.length + 3.5))}ch` }}
          onInput={(event) => type(event.currentTarget.value)} onBlur={() => void keep()}
          onKeyDown={(event) => {
            if (event.key === "Enter") box.current?.blur();
            if (event.key === "Escape" && typed !== null) { type(null); event.stopPropagation(); }
          }}
        />
      ) : <span class="behaviours-text">{value}</span>}
      {missed && <p class="behaviours-miss">{miss(live)}</p>}
      {bad && <p class="form-wrong" role="alert">{bad}</p>}
    </td>
  );
}

/** What is measured, and by how much it misses. */
function miss(one: Unmet): string {
  const seen = one.seen === null ? t("behaviours.seen.nothing") : typeof one.seen === "number" ? number(one.seen, Math.abs(one.seen) < 10 ? 2 : 0) : one.seen;
  const by = one.by === null ? "" : t("behaviours.by", { by: number(one.by, Math.abs(one.by) < 10 ? 2 : 0) });
  return [t("behaviours.seen", { seen }), by, one.text].filter(Boolean).join(" · ");
}
