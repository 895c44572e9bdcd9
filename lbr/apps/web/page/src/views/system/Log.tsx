// The end of what a part has written to its log, read again while it is looked at.
import { useEffect, useRef, useState } from "preact/hooks";
import { plain } from "../../format";
import { Button, Dialog, Field } from "../../parts";
import { save } from "../../saving";
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
  const [wanted, find] = useState("");
  const lines = (text ?? "").split("\n").filter((line) => line.toLowerCase().includes(wanted.trim().toLowerCase())).join("\n");
  useEffect(() => { end.current?.scrollTo(0, end.current.scrollHeight); }, [lines]);
  return (
    <Dialog title={t("log.title", { name: plain(name) })} open onClose={onClose} actions={<Button icon="save" disabled={!text} onClick={() => save(`${name}.log`, new TextEncoder().encode(text ?? ""))}>{t("log.save")}</Button>}>
      <Field label={t("log.find")} type="search" value={wanted} onInput={(event) => find(event.currentTarget.value)} />
      <pre class="log" ref={end} tabIndex={0} aria-label={t("log.title", { name: plain(name) })}>{text === null ? t("rows.wait") : lines || t("log.empty")}</pre>
    </Dialog>
  );
}
