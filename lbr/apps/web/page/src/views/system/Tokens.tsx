// Who may come in: tokens, locked out by a tap; a new one by pairing.
import { useEffect, useState } from "preact/hooks";
import { notice } from "../../notices";
import { Badge, Button, Dialog, Empty, Field } from "../../parts";
import { ConnectPhone } from "../../phone";
import { knows, may } from "../../robot";
import { maybe, t } from "../../words";
import { calledOf, inOrder, rename, revoke, tokens, type Token } from "./manage";

const AGAIN_MS = 3000;
/** As long as the robot takes it. */
const LONGEST = 40;

export function Tokens() {
  const [all, tell] = useState<Token[] | null>(null);
  const [leaving, ask] = useState<Token | null>(null);
  const [naming, call] = useState<{ token: Token; called: string } | null>(null);
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
  const lockOut = async (token: Token): Promise<void> => {
    ask(null);
    const answer = await revoke(token.name);
    if (answer.ok) notice(t("tokens.revoked", { name: calledOf(token) }), "good");
    await look();
  };
  const called = naming?.called.trim() ?? "";
  const give = async (): Promise<void> => {
    if (!naming || !called) return;
    const answer = await rename(naming.token.name, called);
    if (!answer.ok) return;
    call(null);
    notice(t("tokens.renamed", { name: called }), "good");
    await look();
  };
  const sorted = inOrder(all ?? []);
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
                <p><strong>{calledOf(one)}</strong> <Badge tone={one.revoked_at ? "calm" : "good"}>{one.revoked_at ? t("tokens.out") : maybe(`tokens.may.${one.role}`) || one.role}</Badge></p>
                <p class="muted">{one.called ? `${one.name} · ` : ""}{t("tokens.made", { when: day(one.created_at), what: t(one.good_for === "bus" ? "tokens.bus" : one.good_for === "web" ? "tokens.web" : "tokens.both") })}{one.paired_from ? ` · ${one.paired_from}` : ""}{one.expires_at ? ` · ${t("tokens.until", { when: day(one.expires_at) })}` : ""}</p>
              </div>
              {!one.revoked_at && <div class="token-tools">
                <Button kind="quiet" onClick={() => call({ token: one, called: calledOf(one) })} label={`${t("tokens.rename")}: ${calledOf(one)}`} icon="edit" />
                <Button kind="danger" onClick={() => ask(one)} label={`${t("tokens.revoke")}: ${calledOf(one)}`} icon="lock" />
              </div>}
            </li>
          ))}
        </ul>
      )}
      <Dialog
        title={t("tokens.rename.title", { name: naming?.token.name ?? "" })} open={naming !== null} onClose={() => call(null)}
        actions={<><Button kind="quiet" onClick={() => call(null)}>{t("dialog.cancel")}</Button><Button kind="primary" icon="save" disabled={!called} onClick={() => void give()}>{t("rows.save")}</Button></>}
      >
        <form onSubmit={(event) => { event.preventDefault(); void give(); }}>
          <Field label={t("tokens.called")} value={naming?.called ?? ""} maxLength={LONGEST} autofocus autocomplete="off" onInput={(event) => { if (naming) call({ ...naming, called: event.currentTarget.value }); }} />
        </form>
      </Dialog>
      <Dialog title={t("tokens.sure", { name: leaving ? calledOf(leaving) : "" })} open={leaving !== null} onClose={() => ask(null)} actions={<><Button kind="quiet" onClick={() => ask(null)}>{t("dialog.cancel")}</Button><Button kind="danger" icon="lock" onClick={() => { if (leaving) void lockOut(leaving); }}>{t("tokens.revoke")}</Button></>}>
        <p>{t("tokens.text")}</p>
      </Dialog>
      <ConnectPhone open={connecting} onClose={() => connect(false)} />
    </div>
  );
}

const day = (text: string): string => new Date(text).toLocaleDateString(document.documentElement.lang || "en");
