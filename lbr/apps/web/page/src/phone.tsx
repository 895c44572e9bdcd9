// Connects a phone: opens the robot to the network, unless it is open, and shows one code to scan.
import { useEffect, useState } from "preact/hooks";
import { notice } from "./notices";
import { Button, Dialog } from "./parts";
import { consoleLine } from "./robot";
import { t } from "./words";

const AGAIN_MS = 3000;
const OPENS_TRIES = 20, OPENS_AGAIN_MS = 700;
/** Whoever closes the robot from elsewhere locks this page out. */
const HERE = ["localhost", "127.0.0.1", "[::1]"].includes(location.hostname);

/** What the word `pair` answers. */
interface Pairing { digits: string; good_for_s: number; url: string; local?: string; open: boolean; svg: string; fingerprint: string }

const pair = async (options: Parameters<typeof consoleLine>[1]): Promise<Pairing | undefined> => {
  const answer = await consoleLine("pair", options);
  return answer.ok ? answer.data?.data as Pairing | undefined : undefined;
};

/** Returns a code for a robot that is open. The server starts again to listen to the network, so that the answer to `open` may be lost. */
async function code(isLeft: () => boolean): Promise<Pairing | undefined> {
  const found = await pair({});
  if (!found || found.open || isLeft()) return found;
  void consoleLine("open", { quiet: true });
  for (let left = OPENS_TRIES; left > 0 && !isLeft(); left--) {
    await new Promise((done) => setTimeout(done, OPENS_AGAIN_MS));
    const again = await pair({ quiet: true, timeoutMs: AGAIN_MS });
    if (again?.open) return again;
  }
  if (!isLeft()) notice(t("phone.shut"), "warn");
  return undefined;
}

export function ConnectPhone({ open, onClose }: { open: boolean; onClose: () => void }) {
  const [pairing, show] = useState<Pairing | undefined>();
  const [over, setOver] = useState(false);
  useEffect(() => {
    if (!open || over) return;
    let left = false;
    let ends: ReturnType<typeof setTimeout> | undefined;
    void code(() => left).then((found) => {
      if (left) return;
      if (!found) { onClose(); return; }
      show(found);
      ends = setTimeout(() => setOver(true), found.good_for_s * 1000);
    });
    return () => { left = true; clearTimeout(ends); show(undefined); };
  }, [open, over]);
  useEffect(() => { if (!open) setOver(false); }, [open]);
  const close = (): void => {
    onClose();
    void consoleLine("close", { quiet: true });
    notice(t("phone.closed"), "info");
  };
  const back = HERE && pairing ? <Button kind="quiet" icon="lock" onClick={close}>{t("phone.close")}</Button> : undefined;
  return (
    <Dialog title={t("phone.connect")} open={open} onClose={onClose} actions={back}>
      {over ? (
        <>
          <p role="status">{t("phone.over")}</p>
          <Button icon="mobile" onClick={() => setOver(false)}>{t("phone.again")}</Button>
        </>
      ) : pairing ? (
        <>
          {pairing.svg && <img class="phone-picture" alt={pairing.url} src={`data:image/svg+xml,${encodeURIComponent(pairing.svg)}`} />}
          <p>{t("phone.scan")}</p>
          <p class="phone-code"><strong>{pairing.digits.slice(0, 3)} {pairing.digits.slice(3)}</strong> · {pairing.url.split("#")[0]}{pairing.local && ` · ${pairing.local}`}</p>
          {pairing.fingerprint && <p class="muted">{t("phone.warns")} <code class="phone-print">{pairing.fingerprint}</code></p>}
          <p class="muted">{t("phone.cost")}</p>
        </>
      ) : <p role="status">{t("phone.opening")}</p>}
    </Dialog>
  );
}
