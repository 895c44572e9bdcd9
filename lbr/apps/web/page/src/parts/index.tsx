// The pieces that all views are made of.
import type { AllCSSProperties, ComponentChildren, JSX, PartialInputHTMLAttributes } from "preact";
import { render, toChildArray } from "preact";
import { useEffect, useLayoutEffect, useRef, useState } from "preact/hooks";
import { age } from "../format";
import { clock, STALE_MS, type Aged } from "../live";
import { t } from "../words";
import { ICONS, type IconName } from "./icons";

export type { IconName } from "./icons";

let ids = 0;

/** A name for an element that no other has: dialogues are trees of their own, whose `useId` would count from the start again. */
export function useOwnId(): string {
  return useState(() => `own-${++ids}`)[0];
}

/** Draws its children one after the other, so that a slow phone answers to a finger in between. */
export function InTurn({ children }: { children: ComponentChildren }) {
  const [drawn, draw] = useState(0);
  const all = toChildArray(children);
  const over = drawn >= all.length;
  useEffect(() => {
    if (over) return undefined;
    const next = setTimeout(() => draw(drawn + 1));
    return () => clearTimeout(next);
  }, [drawn, over]);
  return <>{all.slice(0, drawn)}</>;
}

export function Icon({ name, class: more = "" }: { name: IconName; class?: string }) {
  return <svg class={`icon ${more}`} viewBox="0 0 24 24" aria-hidden="true"><path d={ICONS[name]} /></svg>;
}

interface ButtonProps extends Omit<JSX.IntrinsicElements["button"], "icon" | "label" | "ref"> {
  kind?: "plain" | "primary" | "quiet" | "danger";
  icon?: IconName;
  /** Its name, where it shows an icon alone. */
  label?: string;
  pressed?: boolean;
  children?: ComponentChildren;
}

export function Button({ kind = "plain", icon, label, pressed, children, class: more = "", ...rest }: ButtonProps) {
  const only = children === undefined ? "button-only" : "";
  return (
    <button type="button" class={`button button-${kind} ${only} ${more}`} aria-label={label} title={label} aria-pressed={pressed} {...rest}>
      {icon && <Icon name={icon} />}
      {children !== undefined && <span>{children}</span>}
    </button>
  );
}

export function Card({ title, icon, actions, children, class: more = "" }: { title?: string; icon?: IconName; actions?: ComponentChildren; children?: ComponentChildren; class?: string }) {
  const id = useOwnId();
  return (
    <section class={`card ${more}`} aria-labelledby={title ? id : undefined}>
      {title && (
        <div class="card-head">
          {icon && <Icon name={icon} />}
          <h2 id={id}>{title}</h2>
          {actions && <div class="card-actions">{actions}</div>}
        </div>
      )}
      {children}
    </section>
  );
}

export type BadgeTone = "good" | "warn" | "bad" | "calm";
export function Badge({ tone = "calm", icon, children }: { tone?: BadgeTone; icon?: IconName; children: ComponentChildren }) {
  return <span class={`badge badge-${tone}`}>{icon && <Icon name={icon} />}<span>{children}</span></span>;
}

interface SliderProps {
  label: string; min: number; max: number; step?: number; value: number; unit?: string; disabled?: boolean;
  show?: (value: number) => string;
  onInput?: (value: number) => void;
  onChange?: (value: number) => void;
}

/** A slider that does not heed what the robot says of its value while a finger is on it. */
export function Slider({ label, min, max, step = 1, value, unit = "", disabled, show, onInput, onChange }: SliderProps) {
  const [held, hold] = useState<number | null>(null);
  const id = useOwnId();
  const shown = held ?? value;
  const fill = `${max > min ? (100 * (Math.min(max, Math.max(min, shown)) - min)) / (max - min) : 0}%`;
  const text = show ? show(shown) : `${shown}${unit}`;
  return (
    <div class="slider">
      <label class="slider-label" for={id}>{label}</label>
      <output class="slider-value" for={id}>{text}</output>
      <input
        id={id} type="range" min={min} max={max} step={step} value={shown} disabled={disabled} aria-valuetext={text} style={{ "--fill": fill } as AllCSSProperties}
        onInput={(event) => { hold(event.currentTarget.valueAsNumber); onInput?.(event.currentTarget.valueAsNumber); }}
        onChange={(event) => { onChange?.(event.currentTarget.valueAsNumber); hold(null); }}
        onPointerUp={(event) => { hold(null); event.currentTarget.blur(); }} onPointerCancel={() => hold(null)} onBlur={() => hold(null)}
      />
    </div>
  );
}

export function Toggle({ label, checked, disabled, onChange }: { label: string; checked: boolean; disabled?: boolean; onChange: (on: boolean) => void }) {
  return (
    <label class="toggle">
      <input type="checkbox" role="switch" checked={checked} disabled={disabled} onChange={(event) => onChange(event.currentTarget.checked)} />
      <span>{label}</span>
    </label>
  );
}

export function Field({ label, class: more = "", ...rest }: { label: string; type?: string } & Omit<PartialInputHTMLAttributes<HTMLInputElement>, "label" | "ref" | "type" | "role">) {
  const id = useOwnId();
  return (
    <div class="field">
      <label class="field-label" for={id}>{label}</label>
      <input id={id} class={`input ${more}`} {...(rest as object)} />
    </div>
  );
}

export function Choice({ label, value, options, onChange }: { label: string; value: string; options: { value: string; text: string }[]; onChange: (value: string) => void }) {
  const id = useOwnId();
  return (
    <div class="field">
      <label class="field-label" for={id}>{label}</label>
      <select id={id} class="input" value={value} onChange={(event) => onChange(event.currentTarget.value)}>
        {options.map((one) => <option key={one.value} value={one.value}>{one.text}</option>)}
      </select>
    </div>
  );
}

/** A few choices side by side, one of which holds. Pressed by a pointer, it leaves the arrow keys to what moves the robot. */
export function Segments<T extends string>({ label, value, options, onChange }: { label: string; value: T; options: { value: T; text: string; icon?: IconName }[]; onChange: (value: T) => void }) {
  const move = (event: KeyboardEvent): void => {
    const step = event.key === "ArrowRight" || event.key === "ArrowDown" ? 1 : event.key === "ArrowLeft" || event.key === "ArrowUp" ? -1 : 0;
    if (!step) return;
    event.preventDefault();
    event.stopPropagation();
    const at = (options.findIndex((one) => one.value === value) + step + options.length) % options.length;
    onChange(options[at]!.value);
    (event.currentTarget as HTMLElement).querySelectorAll("button")[at]?.focus();
  };
  return (
    <div class="segments" role="radiogroup" aria-label={label} onKeyDown={move}>
      {options.map((one) => (
        <button key={one.value} type="button" role="radio" aria-checked={one.value === value} tabIndex={one.value === value ? 0 : -1} onClick={(event) => { onChange(one.value); if (event.detail > 0) event.currentTarget.blur(); }}>
          {one.icon && <Icon name={one.icon} />}<span>{one.text}</span>
        </button>
      ))}
    </div>
  );
}

interface DialogProps { title: string; open: boolean; onClose: () => void; actions?: ComponentChildren; children?: ComponentChildren }

/** A dialogue above the page and below the stop button, which stays within reach of finger and Tab. */
export function Dialog(props: DialogProps) {
  const host = useRef<HTMLElement | null>(null);
  useLayoutEffect(() => {
    if (!props.open) {
      if (host.current) render(null, host.current);
      host.current?.remove();
      host.current = null;
      return;
    }
    if (!host.current) {
      host.current = document.createElement("div");
      document.getElementById("dialogs")!.append(host.current);
    }
    render(<Opened {...props} />, host.current);
  });
  useEffect(() => () => {
    if (host.current) render(null, host.current);
    host.current?.remove();
    host.current = null;
  }, []);
  return null;
}

function Opened({ title, onClose, actions, children }: DialogProps) {
  const id = useOwnId();
  const box = useRef<HTMLDivElement>(null);
  useEffect(() => {
    const before = document.activeElement as HTMLElement | null;
    (box.current?.querySelector<HTMLElement>("[autofocus]") ?? box.current)?.focus();
    return () => before?.focus?.();
  }, []);
  const keep = (event: KeyboardEvent): void => {
    if (event.key === "Escape") onClose();
    if (event.key !== "Tab" || !box.current) return;
    const inside = [...box.current.querySelectorAll<HTMLElement>("button, input, select, textarea, a[href], [tabindex='0']")].filter((one) => !one.hasAttribute("disabled"));
    const ring = [...inside, ...document.querySelectorAll<HTMLElement>(".alarm button, #stop")];
    const at = ring.indexOf(document.activeElement as HTMLElement);
    event.preventDefault();
    ring[(at + (event.shiftKey ? -1 : 1) + ring.length) % ring.length]?.focus();
  };
  useEffect(() => {
    document.addEventListener("keydown", keep);
    return () => document.removeEventListener("keydown", keep);
  });
  return (
    <div class="dialog-veil" onPointerDown={(event) => { if (event.target === event.currentTarget) onClose(); }}>
      <div class="dialog" role="dialog" aria-modal="true" aria-labelledby={id} tabIndex={-1} ref={box}>
        <div class="dialog-head"><h2 id={id}>{title}</h2><Button kind="quiet" icon="close" label={t("dialog.close")} onClick={onClose} /></div>
        <div class="dialog-body">{children}</div>
        {actions && <div class="dialog-foot">{actions}</div>}
      </div>
    </div>
  );
}

/** A plain sign with its age where a stream is old; nothing while it is fresh. */
export function Stale({ sample, after = STALE_MS }: { sample: Aged | null; after?: number }) {
  void clock.value;
  if (!sample) return <Badge icon="warn" tone="warn">{t("age.never")}</Badge>;
  return sample.stale(after) ? <Badge icon="warn" tone="warn">{t("age.stale", { age: age(sample.ageMs()) })}</Badge> : null;
}

export function Empty({ icon, title, children }: { icon: IconName; title: string; children?: ComponentChildren }) {
  return <div class="empty"><Icon name={icon} /><h2>{title}</h2>{children}</div>;
}
