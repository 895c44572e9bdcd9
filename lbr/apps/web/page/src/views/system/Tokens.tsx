// Who may come in: tokens, locked out by a tap; a new one by pairing.
import { useEffect, useState } from "preact/hooks";
import { notice } from "../../notices";
import { Badge, Button, Dialog, Empty } from "../../parts";
import { consoleLine, knows, may } from "../../robot";
import { t } from "../../words";
import { revoke, tokens, type Token } from "./manage";

const AGAIN_MS = 3000;
const OPENS_TRIES = 20, OPENS_AGAIN_MS = 700;

/** What the word `pair` answers. */
interface Pairing { digits: string; url: string; open: boolean; svg: string; fingerprint: string }

export function Tokens() {
  const [all, tell] = useState<Token[] | null>(null);
  const [leaving, ask] = useState("");
  const [pairing, show] = useState<Pairing | null>(null);
  const [opening, wait] = useState(false);
  const look = async (): Promise<void> => {
    const answer = await tokens();
    if (answer.ok) tell(answer.data?.data?.tokens ?? []);
  };
  useEffect(() => {
    if (!may("admin")) return;
    void look();
    const timer = setInterval(() => void look(), AGAIN_MS);
    return () => clearInterval(timer);
  }, []);
  if (!may("admin")) return <Empty icon="lock" title={t("tokens.role")} />;
  const lockOut = async (name: string): Promise<void> => {
    ask("");
    const answer = await revoke(name);
    if (answer.ok) notice(t("tokens.revoked", { name }), "good");
    await look();
  };
  const begin = async (): Promise<void> => {
    const answer = await consoleLine("pair");
    if (answer.ok) show(answer.data?.data as Pairing);
  };
  /** The server starts again to listen to the network, so that the answer to the word itself may be lost. */
  const open = async (): Promise<void> => {
    wait(true);
    void consoleLine("open", { quiet: true });
    for (let left = OPENS_TRIES; left > 0; left--) {
      await new Promise((done) => setTimeout(done, OPENS_AGAIN_MS));
      const answer = await consoleLine("pair", { quiet: true, timeoutMs: AGAIN_MS });
      const found = answer.data?.data as Pairing | undefined;
      if (answer.ok && found?.open) { show(found); break; }
      if (left === 1) notice(t("tokens.shut"), "warn");
    }
    wait(false);
  };
  const sorted = [...(all ?? [])].sort((one, other) => Number(one.revoked_at !== null) - Number(other.revoked_at !== null) || one.name.localeCompare(other.name));
  return (
    <div class="stack">
      <div class="system-tools">
        {knows("pair") && <Button kind="primary" icon="plus" onClick={() => void begin()}>{t("tokens.pair")}</Button>}
      </div>
      {all !== null && sorted.length === 0 ? <Empty icon="lock" title={t("tokens.none")} /> : (
        <ul class="tokens">
          {sorted.map((one) => (
            <li key={one.name} class="token">
              <div>
                <p><strong>{one.name}</strong> <Badge tone={one.revoked_at ? "calm" : "good"}>{one.revoked_at ? t("tokens.out") : one.role}</Badge></p>
                <p class="muted">{t("tokens.made", { when: day(one.created_at), what: t(one.good_for === "bus" ? "tokens.bus" : one.good_for === "web" ? "tokens.web" : "tokens.both") })}{one.paired_from ? ` · ${one.paired_from}` : ""}{one.expires_at ? ` · ${t("tokens.until", { when: day(one.expires_at) })}` : ""}</p>
              </div>
              {!one.revoked_at && <Button kind="danger" onClick={() => ask(one.name)} label={`${t("tokens.revoke")}: ${one.name}`} icon="lock" />}
            </li>
          ))}
        </ul>
      )}
      <Dialog title={t("tokens.sure", { name: leaving })} open={leaving !== ""} onClose={() => ask("")} actions={<><Button kind="quiet" onClick={() => ask("")}>{t("dialog.cancel")}</Button><Button kind="danger" icon="lock" onClick={() => void lockOut(leaving)}>{t("tokens.revoke")}</Button></>}>
        <p>{t("tokens.text")}</p>
      </Dialog>
      <Dialog title={t("tokens.pair")} open={pairing !== null} onClose={() => show(null)} actions={pairing?.open ? undefined : <><Button kind="quiet" onClick={() => show(null)}>{t("dialog.cancel")}</Button><Button kind="primary" disabled={opening} onClick={() => void open()}>{t(opening ? "tokens.opening" : "tokens.open")}</Button></>}>
        {pairing?.open ? (
          <>
            {pairing.svg && <img class="token-picture" alt={pairing.url} src={`data:image/svg+xml,${encodeURIComponent(pairing.svg)}`} />}
            <p>{t("tokens.scan")}</p>
            <p class="token-code"><strong>{pairing.digits.slice(0, 3)} {pairing.digits.slice(3)}</strong> · {pairing.url.split("#")[0]}</p>
            {pairing.fingerprint && <p class="muted">{t("tokens.warns")} <code class="token-print">{pairing.fingerprint}</code></p>}
          </>
        ) : <p>{t("tokens.cost")}</p>}
      </Dialog>
    </div>
  );
}

const day = (text: string): string => new Date(text).toLocaleDateString(document.documentElement.lang || "en");
