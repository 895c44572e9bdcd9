// What is to be mended, in which order: parts that are not well, by what holds them. Pure.
import type { CapabilityStatus } from "../../messages";

/** The robot's own answer to `why`, as far as it is needed here. */
export interface Chain { state: string; text: string; code: string; do: string; first?: number | null; links?: { name: string; about: string }[] }
export interface Lack { root: string; reason: string; do: string; device: boolean; waits: string[] }

export const ill = (part: CapabilityStatus): boolean => part.phase === "failed" || part.phase === "degraded";

/** Which parts hear of which, out of the rows of `channel`. */
export function feedsOf(channels: Record<string, unknown>[]): Record<string, string[]> {
  const found: Record<string, string[]> = {};
  for (const one of channels) {
    const [source, target] = [one["source"], one["target"]].map((port) => String(port).split(".")[0]!);
    if (one["enabled"] !== false) (found[target!] ??= []).push(source!);
  }
  return found;
}

/** What is mended first is what holds the most; what waits for it is named there, and not told again. `feeds` says who hears of whom. */
export function lacks(parts: CapabilityStatus[], chains: Record<string, Chain | undefined>, feeds: Record<string, string[]> = {}): Lack[] {
  const wrong = new Map(parts.filter(ill).map((part) => [part.name, part]));
  const linkOf = (name: string) => { const chain = chains[name]; return chain && chain.state !== "ok" ? chain.links?.[chain.first ?? -1] : undefined; };
  const known = new Set(parts.map((one) => one.name));
  /** The part itself, or its device, is what is told of. */
  const mine = (name: string, about = linkOf(name)?.about ?? name): boolean => about === name || !known.has(about);
  const own = (name: string): boolean => mine(name) && (linkOf(name)?.name === "line" || chains[name]?.code === "unreachable" || wrong.get(name)?.code === "unreachable");
  /** What holds a part: itself where its device is away, or else what it hears of where that is not well. */
  const roots = (name: string, seen: string[]): string[] => {
    if (own(name)) return [name];
    const above = [linkOf(name)?.about ?? name, ...(feeds[name] ?? [])].filter((one) => one !== name && wrong.has(one));
    const held = [...new Set(above.filter((one) => !seen.includes(one)).flatMap((one) => roots(one, [...seen, name])))];
    return held.length > 0 || above.some((one) => seen.includes(one)) ? held : [name];
  };
  const found = new Map<string, Lack>();
  const lackOf = (root: string): Lack => {
    const { reason = "" } = wrong.get(root) ?? {}, chain = chains[root];
    if (!found.has(root)) found.set(root, { root, reason: reason || chain?.text || "", do: chain?.do ?? "", device: own(root), waits: [] });
    return found.get(root)!;
  };
  for (const name of wrong.keys()) {
    const held = roots(name, []);
    for (const root of held.length > 0 ? held : [name]) if (root === name) lackOf(root); else lackOf(root).waits.push(name);
  }
  const failed = (name: string): number => Number(wrong.get(name)?.phase === "failed");
  return [...found.values()].sort((one, other) => other.waits.length - one.waits.length || failed(other.root) - failed(one.root) || one.root.localeCompare(other.root));
}
