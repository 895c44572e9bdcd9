// What is over is news for a moment: a status line shows it, and then what is.
import { useEffect, useState } from "preact/hooks";
import { SHOWN_MS } from "./holding";

/** Whether `what` began to be so a moment ago; empty is no news. */
export function useNews(what: string): boolean {
  const [over, end] = useState("");
  useEffect(() => {
    end("");
    if (!what) return;
    const timer = setTimeout(() => end(what), SHOWN_MS);
    return () => clearTimeout(timer);
  }, [what]);
  return what !== "" && over !== what;
}
