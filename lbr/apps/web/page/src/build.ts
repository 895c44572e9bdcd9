// Which build of the page this is, and whether the robot has another by now. One that is behind moves nothing.
import { signal } from "@preact/signals";
import { t } from "./words";

declare const __BUILD__: string;
/** The digest of the sources that this was built from; empty where it runs from its sources. */
export const BUILD = typeof __BUILD__ === "string" && !import.meta.env?.DEV ? __BUILD__ : "";
/** The robot has another page than this one, and loading it again did not help. */
export const outdated = signal(false);
let forms = 0;
/** How many forms are open that were not saved: the page is not loaded again under them. */
export const unsaved = { add: (count: number): void => { forms += count; } };
/** What a refusal to move is told by. */
export const OLD = { code: "old_page", reason: (): string => t("build.old") };

const TRIED = "lbr.build";

/** What is to be done about the robot's build. `tried` is the one for which the page was loaded again already. Pure. */
export function compare(own: string, told: string, tried: string): "same" | "load" | "old" {
  if (!own || !told || own === told) return "same";
  return tried === told ? "old" : "load";
}

/** Notes the robot's build; another one is loaded once, and where that does not help this page only looks. */
export function noteBuild(told: string, own = BUILD): void {
  const what = compare(own, told, forms > 0 ? told : sessionStorage.getItem(TRIED) ?? "");
  outdated.value = what !== "same";
  if (what !== "load") return;
  sessionStorage.setItem(TRIED, told);
  location.reload();
}

/** Loads the page again because a person asks for it. */
export function loadAgain(): void {
  sessionStorage.removeItem(TRIED);
  location.reload();
}

/** The time to show the page before the browser begins to keep it, which takes processor time. */
const SHOWN_MS = 3000;

/** Has the browser keep the page for when the robot is away, and offer to install it; only where it trusts the line. */
export function keepPage(): void {
  if (!BUILD || !isSecureContext || !navigator.serviceWorker) return;
  setTimeout(() => {
    navigator.serviceWorker.register("./worker.js", { updateViaCache: "none" }).catch((err: unknown) => console.info(`this page is not kept: ${String(err)}`));
  }, SHOWN_MS);
}
