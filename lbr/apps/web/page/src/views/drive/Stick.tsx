// The joystick: a round field for one thumb. Who lifts the thumb, loses the page or the window, drives no more.
import { useEffect, useRef } from "preact/hooks";
import { refused } from "../../holding";
import { may, role } from "../../robot";
import { pace } from "../../live";
import { DEAD } from "../../stick";
import { t } from "../../words";
import { hand, push, sideways } from "./pilot";
import { follow as followTilt, tilts } from "./tilt";

export function Stick() {
  const field = useRef<HTMLDivElement>(null);
  /** Where the field was when the finger came: what moves on the page below a finger steers nothing. */
  const box = useRef({ left: 0, top: 0, width: 1, height: 1 });
  const finger = useRef<number | null>(null);
  const tilting = useRef<(() => void) | null>(null);
  const allowed = may("operate");
  const follow = (event: PointerEvent): void => {
    const { left, top, width, height } = box.current;
    const [x, y] = [(event.clientX - left - width / 2) / (width * 0.36), (top + height / 2 - event.clientY) / (height * 0.36)];
    const far = Math.max(1, Math.hypot(x, y));
    push("stick", x / far, y / far);
  };
  const drop = (event: PointerEvent): void => {
    if (finger.current !== event.pointerId) return;
    off();
  };
  const off = (): void => {
    finger.current = null;
    tilting.current?.();
    tilting.current = null;
    push("stick", 0, 0);
  };
  useEffect(() => {
    // Browsers tell of moves once a picture; where they tell at once, the robot need not wait for it.
    const moved = (event: Event): void => { if (finger.current === (event as PointerEvent).pointerId && !tilting.current) follow(event as PointerEvent); };
    const element = field.current!;
    element.addEventListener("pointerrawupdate", moved);
    return () => {
      element.removeEventListener("pointerrawupdate", moved);
      off();
    };
  }, []);
  const { x, y } = hand.value;
  const way = Math.hypot(x, y);
  return (
    <div
      ref={field} class="drive-stick" role="application" aria-label={allowed ? t(sideways() ? "drive.stick.aside" : "drive.stick") : t("drive.stick.view", { role: t(`role.${role.value ?? "view"}`) })}
      aria-disabled={!allowed} tabIndex={0} data-active={way > DEAD || undefined} data-refused={refused.value || undefined} data-slow={(pace.value?.speed ?? 1) < 1 || undefined}
      onPointerDown={(event) => {
        if (!allowed || finger.current !== null || (event.pointerType === "mouse" && event.button !== 0)) return;
        finger.current = event.pointerId;
        box.current = field.current!.getBoundingClientRect();
        field.current!.setPointerCapture(event.pointerId);
        event.preventDefault();
        if (document.activeElement instanceof HTMLElement) document.activeElement.blur();
        if (tilts.value) tilting.current = followTilt((x, y) => push("stick", x, y));
        else follow(event);
      }}
      onPointerMove={(event) => { if (finger.current === event.pointerId && !tilting.current) follow(event); }}
      onPointerUp={drop} onPointerCancel={drop} onLostPointerCapture={drop} onContextMenu={(event) => event.preventDefault()}
    >
      <svg viewBox="-100 -100 200 200" aria-hidden="true">
        <circle class="drive-stick-field" r="96" />
        <circle class="drive-stick-dead" r="26" />
        <path class="drive-stick-ticks" d="M0-84 7-73H-7zM0 84 7 73H-7zM84 0 73 7V-7zM-84 0-73 7V-7z" />
        {way > DEAD && <path class="drive-stick-beam" d={`M0 0 L${x * 62} ${-y * 62}`} />}
        <g style={{ transform: `translate(${x * 62}px, ${-y * 62}px)` }}>
          <circle class="drive-stick-knob" r="33" />
          <circle class="drive-stick-grip" r="12" />
        </g>
      </svg>
    </div>
  );
}
