// The shell: what is above, beside and below every view.
import { signal } from "@preact/signals";
import { Component, type ComponentType, type Ref } from "preact";
import { useEffect, useLayoutEffect, useRef, useState } from "preact/hooks";
import { unknown } from "./access";
import { loadAgain, outdated } from "./build";
import { Fallen } from "./fallen";
import { Asked } from "./handover";
import { remember } from "./kept";
import { mends, unwell } from "./lacking";
import { link } from "./live";
import { Mend } from "./mend";
import { dismiss, notices, type Tone } from "./notices";
import { Badge, Button, Dialog, Empty, Icon, type IconName } from "./parts";
import { ConnectPhone } from "./phone";
import { away, knows, robot } from "./robot";
import { Settings } from "./settings";
import { SignIn } from "./sign-in";
import { StopButton } from "./stop-button";
import { asksReset, estop, resetEstop, stop } from "./stopping";
import { LACKING, VIEWS, type View } from "./views";
import { t } from "./words";

/** Which view the address names. */
export const place = signal(location.hash.slice(1).split("/")[0] ?? "");
window.addEventListener("hashchange", () => { place.value = location.hash.slice(1).split("/")[0] ?? ""; });

const TONES: Record<Tone, IconName> = { info: "info", good: "check", warn: "warn", bad: "warn" };
const TYPED = "input:not([type=range]):not([type=checkbox]), textarea, select";
const PRESSED = "button, a, input, textarea, select, [role=radio], [role=tab], [role=slider], summary";

function useStopKeys(): void {
  useEffect(() => {
    const press = (event: KeyboardEvent): void => {
      const target = event.target instanceof Element ? event.target : document.body;
      const space = event.code === "Space" && !target.closest(PRESSED) && !target.closest(TYPED);
      if (event.repeat || (event.key !== "Escape" && !space)) return;
      if (space) event.preventDefault();
      void stop();
    };
    window.addEventListener("keydown", press, true);
    return () => window.removeEventListener("keydown", press, true);
  }, []);
}

export function App() {
  useStopKeys();
  const [settings, openSettings] = useState(false);
  const [connecting, connect] = useState(false);
  useEffect(() => {
    const close = (): void => { mends.value = false; };
    window.addEventListener("hashchange", close);
    return () => window.removeEventListener("hashchange", close);
  }, []);
  const known = robot.value;
  const views = known ? VIEWS.filter((view) => view.shows(known)) : [];
  const view = views.find((one) => one.id === place.value) ?? views[0];
  useEffect(() => { if (views[0]) remember("view", views[0].id); }, [views[0]?.id]);
  const signsIn = unknown.value && !known;
  return (
    <>
      <div class="shell">
        <a class="skip" href="#main" onClick={(event) => { event.preventDefault(); document.getElementById("main")?.focus(); }}>{t("shell.skip")}</a>
        <header class="top">
          <h1>
            <img class="mark" src="./icon.svg" alt="" width="34" height="34" />
            <span class="cut">{known?.robot ?? "lbr"}</span>
            {known?.simulated && <Badge icon="info">{t("shell.simulated")}</Badge>}
          </h1>
          <div class="top-end">
            <LinkState />
            {known && unwell.value.length > 0 && <Button class="top-mend" kind="quiet" icon="warn" label={t("lacking.title")} onClick={() => { mends.value = true; }}>{t("lacking.title")}</Button>}
            {knows("phone") && <Button class="top-phone" kind="quiet" icon="mobile" label={t("phone.connect")} onClick={() => connect(true)}>{t("phone.connect")}</Button>}
            <Button kind="quiet" icon="settings" label={t("shell.settings")} onClick={() => openSettings(true)} />
          </div>
        </header>
        <Alarms />
        <nav class="nav" aria-label={t("shell.views")}>
          {views.map((one) => (
            <a key={one.id} class="nav-item" href={`#${one.id}`} aria-current={one === view ? "page" : undefined}><Icon name={one.icon} />{t(one.word)}</a>
          ))}
        </nav>
        <main class="main" id="main" tabIndex={-1} data-view={view?.id}>
          {known && view ? <Shown key={view.id} view={view} /> : signsIn ? <SignIn /> : <Waiting />}
        </main>
      </div>
      <div id="dialogs" />
      <Notices />
      {!signsIn && <StopButton />}
      <Settings open={settings} onClose={() => openSettings(false)} />
      <Dialog title={t("lacking.title")} open={mends.value} onClose={() => { mends.value = false; }}><Shown view={LACKING} /></Dialog>
      <ConnectPhone open={connecting} onClose={() => connect(false)} />
    </>
  );
}

function LinkState() {
  return (
    <p class="linkstate" role="status">
      <span class="linkdot" data-link={link.value} />
      <span class="sr">{t(`link.${link.value}`)}</span>
      <span aria-hidden="true">{t(`link.${link.value}`)}</span>
    </p>
  );
}

function Waiting() {
  if (away.value && robot.value === null) return <Empty icon="unlink" title={t("away.title")}><p>{t("away.text")}</p></Empty>;
  return <div class="loading" role="status"><div class="pulse" />{t("shell.loading")}</div>;
}

/** Keeps the rest of the page clear of what this element covers: `--alarms` is how high it is, and `--head` where what stays in sight begins. */
function useClearance(): Ref<HTMLDivElement> {
  const box = useRef<HTMLDivElement>(null);
  useLayoutEffect(() => {
    const { style } = document.documentElement;
    const seen = new ResizeObserver(() => {
      const high = box.current?.offsetHeight ?? 0;
      if (high > 0) style.setProperty("--alarms", `${high}px`);
      else style.removeProperty("--alarms");
    });
    seen.observe(box.current!);
    return () => { seen.disconnect(); style.removeProperty("--alarms"); };
  }, []);
  return box;
}

/** Who has not acknowledged the emergency stop; all that have is what one expects. */
const waits = (text: string): string => (text.includes("acknowledged by") ? "" : text);

function Alarms() {
  const box = useClearance();
  const { engaged, told, reason, source, text } = estop.value;
  const lost = link.value === "lost" && robot.value !== null;
  const keep = (): void => { asksReset.value = false; };
  return (
    <div class="alarms" ref={box}>
      {engaged && (
        <div class="alarm alarm-stop" role="alert">
          <Icon name="stop" />
          <p class="alarm-said" tabIndex={0}><strong>{told ? t("stop.engaged") : t("stop.engaging")}</strong>{told && [reason.startsWith("pressed on the page") ? t("stop.by.page") : [source, reason].filter(Boolean).join(": "), waits(text)].filter(Boolean).join(" · ")}</p>
          {told && <Button onClick={() => { asksReset.value = true; }}>{t("stop.reset")}</Button>}
        </div>
      )}
      <Fallen />
      {lost && <div class="alarm" role="alert"><Icon name="unlink" /><p>{t("link.lost.long")}</p></div>}
      {outdated.value && <div class="alarm" role="alert"><Icon name="warn" /><p>{t("build.old")}</p><Button onClick={loadAgain}>{t("build.load")}</Button></div>}
      <Dialog
        title={t("stop.reset.title")} open={asksReset.value} onClose={keep}
        actions={<>
          <Button kind="quiet" onClick={keep}>{t("dialog.cancel")}</Button>
          <Button kind="primary" onClick={() => void resetEstop()}>{t("stop.reset")}</Button>
        </>}
      >
        <p>{t("stop.reset.text")}</p>
      </Dialog>
    </div>
  );
}

function Notices() {
  return (
    <div class="notices" role="status" aria-live="polite">
      <Asked />
      {notices.value.map((one) => (
        <div key={one.id} class={`notice notice-${one.tone}`} data-long={one.text.length > 60 || undefined}>
          <Icon name={TONES[one.tone]} /><p>{one.text}</p>
          <Mend code={one.code} about={one.about} onDone={() => dismiss(one.id)} />
          <Button kind="quiet" icon="close" label={t("dialog.close")} onClick={() => dismiss(one.id)} />
        </div>
      ))}
    </div>
  );
}

/** A view, loaded when it is first looked at; one that breaks leaves stop and navigation alone. */
class Shown extends Component<{ view: Pick<View, "load"> }, { Made?: ComponentType; broken?: string }> {
  override state: { Made?: ComponentType; broken?: string } = {};

  override componentDidMount(): void {
    this.load();
  }

  override componentDidCatch(err: unknown): void {
    console.error(err);
    this.setState({ broken: String(err) });
  }

  private load(): void {
    this.props.view.load().then(
      (module) => this.setState({ Made: module.default, broken: undefined }),
      (err: unknown) => this.setState({ broken: String(err) }),
    );
  }

  override render() {
    const { Made, broken } = this.state;
    if (broken) return <Empty icon="warn" title={t("shell.broken")}><p>{broken}</p><Button onClick={() => location.reload()}>{t("shell.again")}</Button></Empty>;
    return Made ? <Made /> : <Waiting />;
  }
}
