// A second control for a base that goes sideways: a bar for another thumb, which turns it and springs back.
import { useEffect, useRef } from "preact/hooks";
import { refused } from "../../holding";
import { Icon } from "../../parts";
import { may } from "../../robot";
import { DEAD } from "../../stick";
import { t } from "../../words";
import { hand, push } from "./pilot";

export function Turner() {
  const bar = useRef<HTMLDivElement>(null);
  const finger = useRef<number | null>(null);
  const allowed = may("operate");
  const follow = (event: PointerEvent): void => {
    const { left, width } = bar.current!.getBoundingClientRect();
    push("turn", 0, 0, Math.max(-1, Math.min(1, (event.clientX - left - width / 2) / (width * 0.4))));
  };
  const off = (): void => {
    finger.current = null;
    push("turn", 0, 0);
  };
  const drop = (event: PointerEvent): void => { if (finger.current === event.pointerId) off(); };
  useEffect(() => off, []);
  const { turn } = hand.value;
  return (
    <div
      ref={bar} class="drive-turner" role="application" aria-label={t("drive.turner")} aria-disabled={!allowed} tabIndex={0}
      data-active={Math.abs(turn) > DEAD || undefined} data-refused={refused.value || undefined}
      onPointerDown={(event) => {
        if (!allowed || finger.current !== null || (event.pointerType === "mouse" && event.button !== 0)) return;
        finger.current = event.pointerId;
        bar.current!.setPointerCapture(event.pointerId);
        event.preventDefault();
        if (document.activeElement instanceof HTMLElement) document.activeElement.blur();
        follow(event);
      }}
      onPointerMove={(event) => { if (finger.current === event.pointerId) follow(event); }}
      onPointerUp={drop} onPointerCancel={drop} onLostPointerCapture={drop} onContextMenu={(event) => event.preventDefault()}
    >
      <Icon name="turnleft" /><span class="drive-turner-knob" style={{ left: `${50 + turn * 36}%` }} /><Icon name="turn" />
    </div>
  );
}
