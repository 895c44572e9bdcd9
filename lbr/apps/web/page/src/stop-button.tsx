// The stop: always there, above all else. A press stops at once; held for a second it is the emergency stop.
import { useEffect, useRef, useState } from "preact/hooks";
import { engage, stop } from "./stopping";
import { t } from "./words";

const HOLD_MS = 1000;

export function StopButton() {
  const [pressed, press] = useState(false);
  const timer = useRef<ReturnType<typeof setTimeout> | undefined>(undefined);
  const pressedAt = useRef(-HOLD_MS);
  const down = (): void => {
    if (timer.current !== undefined) return;
    press(true);
    pressedAt.current = performance.now();
    void stop();
    timer.current = setTimeout(() => {
      up();
      navigator.vibrate?.(200);
      void engage();
    }, HOLD_MS);
  };
  const up = (): void => {
    clearTimeout(timer.current);
    timer.current = undefined;
    press(false);
  };
  useEffect(() => {
    window.addEventListener("blur", up);
    return () => window.removeEventListener("blur", up);
  }, []);
  const isPress = (event: KeyboardEvent): boolean => event.key === "Enter" || event.key === " ";
  return (
    <button
      id="stop" type="button" class="stop" data-pressed={pressed || undefined}
      onPointerDown={(event) => { event.currentTarget.setPointerCapture?.(event.pointerId); down(); }}
      onPointerUp={() => { pressedAt.current = performance.now(); up(); }} onPointerCancel={up} onContextMenu={(event) => event.preventDefault()}
      onKeyDown={(event) => { if (isPress(event)) { event.preventDefault(); if (!event.repeat) down(); } }}
      onKeyUp={(event) => { if (isPress(event)) up(); }}
      onClick={() => { if (performance.now() - pressedAt.current > 2 * HOLD_MS) void stop(); }}
    >
      <svg class="stop-ring" viewBox="0 0 36 36" aria-hidden="true"><circle cx="18" cy="18" r="15.915" pathLength="100" /></svg>
      <span>{t("stop.stop")} </span>
      <span class="stop-hint">{t("stop.hint")}</span>
      <span class="sr"> {t("stop.label")}</span>
    </button>
  );
}
