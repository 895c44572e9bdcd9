// Who is unknown to the robot pairs by six digits, or shows a token.
import { useState } from "preact/hooks";
import { pair, revoked, signIn } from "./access";
import { enter } from "./begin";
import { deviceName } from "./device";
import { Button, Card, Field, Icon } from "./parts";
import { t } from "./words";

export function SignIn() {
  const [code, setCode] = useState("");
  const [name, setName] = useState(deviceName);
  const [shown, setShown] = useState("");
  const [byToken, setByToken] = useState(false);
  const [busy, setBusy] = useState(false);
  const submit = async (event: Event): Promise<void> => {
    event.preventDefault();
    setBusy(true);
    const done = byToken ? await signIn(shown) : await pair(code, name.trim());
    setBusy(false);
    if (done) await enter();
  };
  return (
    <Card class="sign">
      <h2>{t("sign.title")}</h2>
      {revoked.value && <p class="sign-revoked" role="alert"><Icon name="lock" />{t("sign.revoked")}</p>}
      <p class="muted">{t("sign.text")}</p>
      <form onSubmit={(event) => void submit(event)}>
        {byToken ? (
          <Field label={t("sign.token")} type="password" autocomplete="current-password" required value={shown} onInput={(event) => setShown(event.currentTarget.value)} />
        ) : (
          <>
            <Field label={t("sign.code")} class="digits" inputMode="numeric" autocomplete="one-time-code" pattern="[0-9 ]{6,7}" maxLength={7} required value={code} onInput={(event) => setCode(event.currentTarget.value)} />
            <Field label={t("sign.name")} required maxLength={40} value={name} onInput={(event) => setName(event.currentTarget.value)} />
          </>
        )}
        <Button type="submit" kind="primary" disabled={busy} icon="key">{byToken ? t("sign.in") : t("sign.pair")}</Button>
        <Button kind="quiet" onClick={() => setByToken(!byToken)}>{byToken ? t("sign.pair") : t("sign.use")}</Button>
      </form>
    </Card>
  );
}
