// Who may come in: tokens, locked out by a tap; a new one by pairing.
import { useEffect, useState } from "preact/hooks";
import { notice } from "../../notices";
import { Badge, Button, Dialog, Empty } from "../../parts";
import { ConnectPhone } from "../../phone";
import { knows, may } from "../../robot";
import { maybe, t } from "../../words";
import { revoke, tokens, type Token } from "./manage";

const AGAIN_MS = 3000;

export function Tokens() {
  const [all, tell] = useState<Token[] | null>(null);
  const [leaving, ask] = useState("");
  const [connecting, connect] = useState(false);
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
  const sorted = [...(all ?? [])].sort((one, other) => Number(one.revoked_at !== null) - Number(other.revoked_at !== null) || one.name.localeCompare(other.name));
  return (
    <div class="stack">
      <div class="system-tools">
        {knows("phone") && <Button kind="primary" icon="mobile" onClick={() => connect(true)}>{t("phone.connect")}</Button>}
      </div>
      {all !== null && sorted.length === 0 ? <Empty icon="lock" title={t("tokens.none")} /> : (
        <ul class="tokens">
          {sorted.map((one) => (
            <li key={one.name} class="token">
              <div>
                <p><strong>{one.name}</strong> <Badge tone={one.revoked_at ? "calm" : "good"}>{one.revoked_at ? t("tokens.out") : maybe(`tokens.may.${one.role}`) || one.role}</Badge></p>
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
      <ConnectPhone open={connecting} onClose={() => connect(false)} />
    </div>
  );
}

const day = (text: string): string => new Date(text).toLocaleDateString(document.documentElement.lang || "en");
