// Appearance, language, and who this is.
import { signOut, token } from "./access";
import { theme, type Theme } from "./begin";
import { Button, Dialog, Icon, Segments } from "./parts";
import { may, robot } from "./robot";
import { language, t, type Language } from "./words";

export function Settings({ open, onClose }: { open: boolean; onClose: () => void }) {
  const known = robot.value;
  return (
    <Dialog title={t("settings.page")} open={open} onClose={onClose}>
      <div class="stack">
        <h3 class="field-label">{t("settings.theme")}</h3>
        <Segments<Theme>
          label={t("settings.theme")} value={theme.value} onChange={(value) => { theme.value = value; }}
          options={[{ value: "auto", text: t("settings.auto") }, { value: "dark", text: t("settings.dark") }, { value: "light", text: t("settings.light") }]}
        />
        <h3 class="field-label">{t("settings.language")}</h3>
        <Segments<Language>
          label={t("settings.language")} value={language.value} onChange={(value) => { language.value = value; }}
          options={[{ value: "en", text: "English" }, { value: "de", text: "Deutsch" }]}
        />
        {known && <p class="muted">{t("settings.you")}: {[token.value.split(".")[0], t(`role.${known.role}`)].filter(Boolean).join(", ")}. {t("settings.about", { version: known.version, robot: known.robot })}</p>}
        {may("operate") && <div><a class="button button-plain" href="#system/settings" onClick={onClose}><Icon name="system" /><span>{t("settings.robot")}</span></a></div>}
        {token.value && <div><Button kind="danger" onClick={() => void signOut()}>{t("sign.out")}</Button></div>}
      </div>
    </Dialog>
  );
}
