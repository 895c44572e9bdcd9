// A number between two buttons: typed, or stepped through the values that people use.
import { useState } from "preact/hooks";
import { Button } from "../../parts";
import { t } from "../../words";

/** `round`: after the last step comes the first. */
export interface Bounds { least: number; most: number; steps: readonly number[]; digits: number; round?: boolean }

/** A value within its bounds; `otherwise` for what is no number. */
export function within(value: number, { least, most, digits }: Bounds, otherwise: number): number {
  if (typeof value !== "number" || !Number.isFinite(value)) return otherwise;
  return Number(Math.min(most, Math.max(least, value)).toFixed(digits));
}

/** The next value of the steps in a direction; the value itself at the end. */
export function stepped(value: number, { steps, round }: Bounds, by: 1 | -1): number {
  const next = by > 0 ? steps.find((one) => one > value) : [...steps].reverse().find((one) => one < value);
  return next ?? (round ? (by > 0 ? steps[0]! : steps.at(-1)!) : value);
}

export function Value({ label, unit, bounds, value, onChange }: { label: string; unit: string; bounds: Bounds; value: number; onChange: (value: number) => void }) {
  const [typed, type] = useState<string | null>(null);
  const done = (): void => {
    if (typed !== null && typed.trim() !== "") onChange(within(Number(typed.replace(",", ".")), bounds, value));
    type(null);
  };
  const step = (by: 1 | -1): void => { type(null); onChange(stepped(value, bounds, by)); };
  return (
    <div class="drive-value" role="group" aria-label={label}>
      <Button kind="quiet" icon="minus" label={t("drive.less", { what: label })} onClick={() => step(-1)} />
      <label class="drive-value-field">
        <input
          class="num" aria-label={label} inputMode="decimal" size={4} value={typed ?? String(value)} onFocus={(event) => event.currentTarget.select()}
          onInput={(event) => type(event.currentTarget.value)} onBlur={done}
          onKeyDown={(event) => {
            if (event.key === "Enter") event.currentTarget.blur();
            if (event.key === "ArrowUp" || event.key === "ArrowDown") { event.preventDefault(); step(event.key === "ArrowUp" ? 1 : -1); }
          }}
        />
        <span aria-hidden="true">{unit}</span>
      </label>
      <Button kind="quiet" icon="plus" label={t("drive.more", { what: label })} onClick={() => step(1)} />
    </div>
  );
}
