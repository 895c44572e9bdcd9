// What is over is news for a moment: a status line shows it, and then what is.
import { useEffect, useRef, useState } from "preact/hooks";
import { SHOWN_MS } from "./holding";

/** Whether `what` began to be so a moment ago, while this was shown; empty is no news, null is not heard yet. */
export function useNews(what: string | null, forMs = SHOWN_MS): boolean {
  const [news, tell] = useState("");
  const heard = useRef(false);
  useEffect(() => {
    if (what === null) return undefined;
    tell(heard.current ? what : "");
    heard.current = true;
    const timer = setTimeout(() => tell(""), forMs);
    return () => clearTimeout(timer);
  }, [what]);
  return Boolean(what) && news === what;
}
