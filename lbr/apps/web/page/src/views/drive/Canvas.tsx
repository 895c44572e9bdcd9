// A canvas that is drawn when it has to be, as sharp as the screen, in the page's colours.
import { useEffect, useRef } from "preact/hooks";

export interface Pen { ctx: CanvasRenderingContext2D; width: number; height: number; colour: (name: string) => string }

/** Calls `paint` on each frame after `ask` said that something is new, and whenever size or colours change. */
export function Canvas({ paint, subscribe, label, class: more = "" }: { paint: (pen: Pen) => void; subscribe: (ask: () => void) => () => void; label: string; class?: string }) {
  const canvas = useRef<HTMLCanvasElement>(null);
  const painter = useRef(paint);
  painter.current = paint;
  useEffect(() => {
    const shown = canvas.current!;
    const ctx = shown.getContext("2d")!;
    let frame = 0;
    const draw = (): void => {
      frame = 0;
      const { width, height } = shown.getBoundingClientRect();
      const ratio = Math.min(3, devicePixelRatio || 1);
      if (shown.width !== Math.round(width * ratio)) shown.width = Math.round(width * ratio);
      if (shown.height !== Math.round(height * ratio)) shown.height = Math.round(height * ratio);
      const style = getComputedStyle(shown);
      ctx.setTransform(ratio, 0, 0, ratio, 0, 0);
      ctx.clearRect(0, 0, width, height);
      if (width > 0 && height > 0) painter.current({ ctx, width, height, colour: (name) => style.getPropertyValue(name).trim() });
    };
    const ask = (): void => { frame ||= requestAnimationFrame(draw); };
    const sized = new ResizeObserver(ask);
    sized.observe(shown);
    const dark = matchMedia("(prefers-color-scheme: dark)");
    dark.addEventListener("change", ask);
    const themed = new MutationObserver(ask);
    themed.observe(document.documentElement, { attributeFilter: ["data-theme"] });
    const done = subscribe(ask);
    ask();
    return () => {
      cancelAnimationFrame(frame);
      sized.disconnect();
      dark.removeEventListener("change", ask);
      themed.disconnect();
      done();
    };
  }, [subscribe]);
  return <canvas ref={canvas} class={more} role="img" aria-label={label} />;
}
