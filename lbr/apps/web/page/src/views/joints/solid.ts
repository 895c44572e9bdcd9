// Whether bodies are drawn in three dimensions: where a graphics card draws them, or where this browser's user chose it.
import { signal } from "@preact/signals";
import { remember, remembered } from "../../kept";

/** Names of renderers that draw by the processor: Chromium's, Mesa's, Windows'. */
const SOFTWARE = /swiftshader|llvmpipe|softpipe|basic render|software/i;

/** Whether a graphics card draws. A processor that draws holds up the page, and the robot where both share a computer. */
export const hasCard = ((): boolean => {
  try {
    const gl = document.createElement("canvas").getContext("webgl2", { failIfMajorPerformanceCaveat: true });
    if (!gl) return false;
    const named = gl.getExtension("WEBGL_debug_renderer_info");
    const renderer = String(gl.getParameter(named ? named.UNMASKED_RENDERER_WEBGL : gl.RENDERER));
    gl.getExtension("WEBGL_lose_context")?.loseContext();
    return !SOFTWARE.test(renderer);
  } catch {
    return false;
  }
})();

export const solid = signal(remembered<boolean | null>("solid", null) ?? hasCard);

export function choose(value: boolean): void {
  solid.value = value;
  remember("solid", value);
}
