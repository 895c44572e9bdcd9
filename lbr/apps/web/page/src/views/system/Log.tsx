// The end of what a part has written to its log, read again while it is looked at.
import { useEffect, useRef, useState } from "preact/hooks";
import { plain } from "../../format";
import { Dialog } from "../../parts";
import { t } from "../../words";
import { log } from "./manage";

const AGAIN_MS = 2000;

export function Log({ name, onClose }: { name: string; onClose: () => void }) {
  const [text, tell] = useState<string | null>(null);
  const end = useRef<HTMLPreElement>(null);
  useEffect(() => {
    let over = false;
    const look = (): void => void log(name).then((answer) => { if (!over && answer.ok) tell(answer.data?.data?.text ?? ""); });
    look();
    const timer = setInterval(look, AGAIN_MS);
    return () => { over = true; clearInterval(timer); };
  }, [name]);
  useEffect(() => { end.current?.scrollTo(0, end.current.scrollHeight); }, [text]);
  return (
    <Dialog title={t("log.title", { name: plain(name) })} open onClose={onClose}>
      <pre class="log" ref={end} tabIndex={0} aria-label={t("log.title", { name: plain(name) })}>{text === null ? t("rows.wait") : text || t("log.empty")}</pre>
    </Dialog>
  );
}
