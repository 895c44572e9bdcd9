// What is plugged in: each with what it is and the rows that would have the robot use it, written on a yes.
import { useState } from "preact/hooks";
import { notice } from "../../notices";
import { Badge, Button, Dialog, Empty } from "../../parts";
import { may } from "../../robot";
import { t } from "../../words";
import { changeAll, devices, type Looked, type Offer } from "./manage";
import { noteMade } from "./undo";

export function Devices() {
  const [found, tell] = useState<Looked | null>(null);
  const [busy, wait] = useState(false);
  const [chosen, ask] = useState<Offer | null>(null);
  if (!may("admin")) return <Empty icon="lock" title={t("devices.role")} />;
  const look = async (): Promise<void> => {
    wait(true);
    const answer = await devices();
    wait(false);
    if (answer.ok) tell(answer.data?.data ?? null);
  };
  const write = async (offer: Offer): Promise<void> => {
    ask(null);
    const answer = await changeAll(offer.changes, true);
    if (answer.ok) notice(t("devices.written"), "good");
    if (answer.ok) noteMade(t("devices.written"), t("devices.rows"), answer);
    await look();
  };
  const offered = (address: string): Offer | undefined => found?.proposals.find((one) => one.address === address);
  return (
    <div class="stack">
      <div class="system-tools">
        <Button kind="primary" icon="system" disabled={busy} onClick={() => void look()}>{t(busy ? "devices.looking" : "devices.look")}</Button>
      </div>
      <p class="muted">{t("devices.about")}</p>
      {found?.hints.map((hint) => <p key={hint} class="muted">{hint}</p>)}
      {found !== null && found.devices.length === 0 ? <Empty icon="system" title={t("devices.none")} /> : (
        <ul class="tokens">
          {found?.devices.map((one) => {
            const offer = offered(one.address);
            return (
              <li key={one.address} class="token">
                <div>
                  <p><strong>{one.what || one.name || one.place}</strong> {one.row && <Badge tone="good">{one.row}</Badge>}</p>
                  <p class="muted">{one.address}{one.serial ? ` · ${one.serial}` : ""}{one.text ? ` · ${one.text}` : ""}</p>
                  {offer && <p>{offer.text}</p>}
                  {offer?.problems.map((text) => <p key={text} class="muted">{text}</p>)}
                </div>
                {offer && offer.changes.length > 0 && offer.problems.length === 0 && <Button icon="plus" onClick={() => ask(offer)}>{t("devices.preview")}</Button>}
              </li>
            );
          })}
        </ul>
      )}
      <Dialog title={t("devices.sure")} open={chosen !== null} onClose={() => ask(null)} actions={<><Button kind="quiet" onClick={() => ask(null)}>{t("dialog.cancel")}</Button><Button kind="primary" icon="plus" onClick={() => chosen && void write(chosen)}>{t("devices.write")}</Button></>}>
        <p>{chosen?.text}</p>
        <ul>{chosen?.differences.map((line) => <li key={line}>{line}</li>)}</ul>
      </Dialog>
    </div>
  );
}
