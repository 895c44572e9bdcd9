// Sends what is larger than a request's body may be: packed, in parts.
import { fetchJson } from "../../robot";
import type { Answer } from "../../access";

const PART_BYTES = 30_000;
let count = 0;

/** Sends it, and returns by what name requests may speak of it; or the answer that refused it. */
export async function upload(content: Uint8Array<ArrayBuffer> | string): Promise<{ name: string; refused?: Answer }> {
  const name = `page-${Date.now().toString(36)}-${++count}`;
  const bytes = typeof content === "string" ? new TextEncoder().encode(content) : content;
  const packed = new Uint8Array(await new Response(new Blob([bytes]).stream().pipeThrough(new CompressionStream("gzip"))).arrayBuffer());
  for (let part = 0; part * PART_BYTES < packed.length; part++) {
    const slice = packed.subarray(part * PART_BYTES, (part + 1) * PART_BYTES);
    const answer = await fetchJson("api/motion/upload", { method: "POST", body: { upload: name, part, content: btoa(Array.from(slice, (one) => String.fromCharCode(one)).join("")) } });
    if (!answer.ok) return { name, refused: answer };
  }
  return { name };
}
