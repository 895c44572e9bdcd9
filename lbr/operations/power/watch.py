"""The file-safe shutdown as a pure decision: state, event and time give the next state and the tasks.

Only consecutive readings below the threshold lead to a countdown, and the newest must be below it when the countdown
ends. After that, until logind is asked, only `disarm` and `cancel` prevent the shutdown.
"""

from dataclasses import replace
from math import inf

from lbr.messages.codes import ReasonCode
from lbr.messages.power import PowerPhase, UpsState
from lbr.operations.power import PowerSettings
from lbr.operations.power.state import (
    Answered,
    Arm,
    Cancel,
    Event,
    News,
    Outcome,
    Parked,
    Reading,
    Run,
    Task,
    Tick,
    Watch,
)
from lbr.operations.power.supply import View, look

PENDING = frozenset({"countdown", "parking", "failed"})
"""The phases that `cancel` ends."""
TOO_LATE = frozenset({"powering_off", "off"})
MARGIN_S = 2.0


def begin(*, armed: bool, warn_v: float, shutdown_v: float, now: float) -> Watch:
    """Return the initial state, also after a restart: an earlier countdown is forgotten."""
    return Watch(armed, warn_v, shutdown_v, "watching" if armed else "disarmed", seen_s=now)


def decide(watch: Watch, event: Event, now: float, settings: PowerSettings) -> Outcome:
    """Return the next state, with its tasks and news."""
    outcome: Outcome = (watch, ())
    match event:
        case Reading():
            outcome = _settle(*_read(watch, event.ups, now, settings), now, settings)
        case Tick():
            outcome = _settle(*_silence(watch, now, settings), now, settings)
        case Arm():
            outcome = _arm(watch, event)
        case Cancel():
            outcome = _cancel(watch, event)
        case Parked() if watch.phase == "parking":
            outcome = _power_off(watch, event.trouble, now, settings)
        case Answered() if watch.phase == "powering_off":
            outcome = _pretended(watch) if event.pretended else _answered(watch, event.trouble, now, settings)
    return outcome


def refusal(watch: Watch, event: Arm | Cancel) -> str:
    """Return why a request is refused, or an empty string."""
    if watch.phase in TOO_LATE and not _pretends(watch):
        return "too late: the computer is going down"
    if isinstance(event, Cancel):
        return "" if watch.phase in PENDING else f"there is no shutdown to cancel: {watch.phase}"
    warn_v = watch.warn_v if event.warn_v is None else event.warn_v
    shutdown_v = watch.shutdown_v if event.shutdown_v is None else event.shutdown_v
    if shutdown_v > warn_v:
        return f"shutdown_v ({shutdown_v:g} V) must not be above warn_v ({warn_v:g} V)"
    return ""


def code(watch: Watch) -> ReasonCode:
    """Return the code of the state's sentence, or an empty one for a voltage that is good."""
    if watch.phase in {"disarmed", "watching", "warning"}:
        well = "limit" if watch.phase == "warning" else ""
        return "stale_sensor" if watch.view.trouble else "cancelled" if watch.cancelled else well
    if watch.phase == "failed":
        return "failed"
    return "not_possible" if _pretends(watch) else "shutting_down"


def _read(watch: Watch, ups: UpsState, now: float, settings: PowerSettings) -> Outcome:
    view = look(ups, watch.warn_v, watch.shutdown_v, settings)
    if view.trouble:
        return _troubled(watch, view, now, settings)
    if watch.view.backed != view.backed:  # the other source: counts of the first do not apply to it
        watch = replace(watch, low=None, well=None, wanting=None)
    known: tuple[News, ...] = (News("supply_known", view.text, "info"),) if watch.silent else ()
    watch = replace(
        watch,
        view=view,
        seen_s=now,
        low=_longer(watch.low, now, so=view.low),
        well=_longer(watch.well, now, so=view.well),
        wanting=_longer(watch.wanting, now, so=view.wanting),
        silent=False,
    )
    if _well(watch, settings):
        watch = replace(watch, cancelled=False)
    watch, news = _warn(watch, settings)
    return watch, (*known, *news)


def _warn(watch: Watch, settings: PowerSettings) -> Outcome:
    wanting = watch.wanting is not None and watch.wanting.samples >= settings.hold_samples
    if wanting and not watch.warned:
        text = watch.view.text if watch.view.backed else f"{watch.view.text}, below {watch.view.warn_v:g} V"
        return replace(watch, warned=True), (News("supply_low", text + _unguarded(watch)),)
    if watch.view.fine and watch.warned:
        return replace(watch, warned=False), (News("supply_good", watch.view.text, "info"),)
    return watch, ()


def _unguarded(watch: Watch) -> str:
    return "" if watch.armed else "; the computer is not shut down in time, because that is not armed"


def _silence(watch: Watch, now: float, settings: PowerSettings) -> Outcome:
    silent_s = now - watch.seen_s
    if silent_s < settings.stale_s:
        return watch, ()
    view = watch.view if watch.view.trouble else View(trouble=f"the supply was last read {silent_s:.0f} s ago")
    return _troubled(watch, view, now, settings)


def _troubled(watch: Watch, view: View, now: float, settings: PowerSettings) -> Outcome:
    """Keep the counts for a moment, then reset them and report that: a missing reading is no low voltage."""
    watch = replace(watch, view=replace(view, backed=watch.view.backed))
    if now - watch.seen_s < settings.stale_s:
        return watch, ()
    news: tuple[News, ...] = (
        () if watch.silent else (News("supply_unknown", "the voltage is not known" + _unguarded(watch)),)
    )
    return replace(watch, silent=True, low=None, well=None, wanting=None), news


def _settle(watch: Watch, news: tuple[Task | News, ...], now: float, settings: PowerSettings) -> Outcome:
    """Return the phase for the present state."""
    after, more = _next(watch, now, settings)
    return after, (*news, *more)


def _next(watch: Watch, now: float, settings: PowerSettings) -> Outcome:
    outcome: Outcome = (watch, ())
    match watch.phase:
        case "watching" | "warning":
            outcome = _guard(watch, now, settings)
        case "countdown":
            outcome = _count(watch, now, settings)
        case "parking" if now >= watch.until_s:
            outcome = _power_off(watch, "parking took too long", now, settings)
        case "powering_off" if now >= watch.until_s:
            outcome = _answered(watch, f"logind did not answer within {settings.answer_s:g} s", now, settings)
        case "off" if _pretends(watch) and _well(watch, settings):
            outcome = _rest(watch), ()
        case "off" if now >= watch.until_s:
            trouble = f"it still runs {settings.off_s:g} s after logind agreed"
            outcome = _answered(watch, trouble, now, settings)
        case "failed":
            outcome = _try_again(watch, now, settings)
        case "disarmed":
            outcome = replace(watch, reason=watch.view.text), ()
    return outcome


def _guard(watch: Watch, now: float, settings: PowerSettings) -> Outcome:
    if watch.view.low and not watch.cancelled and _low(watch, settings):
        text = f"{watch.view.text}, below {watch.view.shutdown_v:g} V: the computer is shut down"
        text += f" in {settings.countdown_s:g} s unless it is cancelled"
        watch = replace(watch, phase="countdown", reason=text, until_s=now + settings.countdown_s)
        return watch, (News("shutdown_countdown", text), "ask_can")
    return _rest(watch), ()


def _rest(watch: Watch) -> Watch:
    """Return to watching, or to a warning."""
    phase: PowerPhase = "warning" if watch.warned or watch.silent or watch.cancelled else "watching"
    reason = (
        f"{watch.view.text}; the shutdown was cancelled until it is good again" if watch.cancelled else watch.view.text
    )
    return replace(watch, phase=phase, reason=reason, until_s=inf)


def _count(watch: Watch, now: float, settings: PowerSettings) -> Outcome:
    if watch.silent:
        text = f"the countdown is off: {watch.view.trouble}"
        return _rest(watch), (News("shutdown_off", text),)
    if _well(watch, settings):
        return _rest(watch), (News("shutdown_off", f"the countdown is off: {watch.view.text}", "info"),)
    if now >= watch.until_s and watch.view.low:
        parking_s = settings.park_s + settings.let_go_s + MARGIN_S
        watch = replace(watch, phase="parking", reason=watch.view.text, until_s=now + parking_s)
        return watch, (News("shutdown_parking", f"{watch.view.text}: parking, then shutting down"), "park")
    return watch, ()


def _power_off(watch: Watch, trouble: str, now: float, settings: PowerSettings) -> Outcome:
    text = "the computer is asked to power off" + (f"; parking: {trouble}" if trouble else "")
    watch = replace(watch, phase="powering_off", reason=text, until_s=now + settings.answer_s + MARGIN_S)
    return watch, (News("shutdown_now", text), "stop_parking", "power_off")


def _pretended(watch: Watch) -> Outcome:
    text = "the supply is emulated: a real robot would power off now, this computer stays on"
    return replace(watch, phase="off", reason=text, until_s=inf), (News("shutdown_pretended", text),)


def _pretends(watch: Watch) -> bool:
    """Return whether the shutdown was only pretended: the computer stays on, and commands still work."""
    return watch.phase == "off" and watch.until_s == inf


def _answered(watch: Watch, trouble: str, now: float, settings: PowerSettings) -> Outcome:
    if not trouble:
        text = "the computer powers off"
        return replace(watch, phase="off", reason=text, until_s=now + settings.off_s), (News("shutdown_agreed", text),)
    text = f"the computer does not power off: {trouble}; tried again in {settings.retry_s:g} s"
    return replace(watch, phase="failed", reason=text, until_s=now + settings.retry_s), (
        News("shutdown_failed", text, "error"),
    )


def _try_again(watch: Watch, now: float, settings: PowerSettings) -> Outcome:
    if _well(watch, settings):
        return _rest(watch), (News("shutdown_off", f"no shutdown any more: {watch.view.text}", "info"),)
    if now >= watch.until_s and watch.view.low and _low(watch, settings):
        return _power_off(watch, "", now, settings)
    return watch, ()


def _arm(watch: Watch, event: Arm) -> Outcome:
    if refusal(watch, event):
        return watch, ()
    warn_v = watch.warn_v if event.warn_v is None else event.warn_v
    shutdown_v = watch.shutdown_v if event.shutdown_v is None else event.shutdown_v
    moved = (warn_v, shutdown_v) != (watch.warn_v, watch.shutdown_v)
    watch = replace(watch, armed=event.armed, warn_v=warn_v, shutdown_v=shutdown_v)
    if moved:  # the counts belong to other thresholds
        watch = replace(watch, low=None, well=None, wanting=None, warned=False)
    text = (
        f"warns below {warn_v:g} V, shuts down below {shutdown_v:g} V" if event.armed else "shuts nothing down any more"
    )
    news = News("armed" if event.armed else "disarmed", f"{event.sender}: {text}", "info", about=event.sender)
    if not event.armed:
        stop: tuple[Task, ...] = ("stop_parking",) if watch.phase == "parking" else ()
        return replace(watch, phase="disarmed", reason=text, until_s=inf, cancelled=False), (news, "keep", *stop)
    if watch.phase == "disarmed" or (moved and watch.phase == "countdown"):
        watch = _rest(watch)
    return watch, (news, "keep", "ask_can")


def _cancel(watch: Watch, event: Cancel) -> Outcome:
    if watch.phase not in PENDING:
        return watch, ()
    stop: tuple[Task, ...] = ("stop_parking",) if watch.phase == "parking" else ()
    watch = _rest(replace(watch, cancelled=True))
    return watch, (News("shutdown_cancelled", f"{event.sender} cancelled the shutdown; {watch.view.text}"), *stop)


def _low(watch: Watch, settings: PowerSettings) -> bool:
    """Return whether readings have been low for long enough, by the times of the readings."""
    low = watch.low
    return low is not None and low.samples >= settings.hold_samples and watch.seen_s - low.since_s >= settings.hold_s


def _well(watch: Watch, settings: PowerSettings) -> bool:
    return watch.well is not None and watch.well.samples >= settings.hold_samples


def _longer(run: Run | None, now: float, *, so: bool) -> Run | None:
    if not so:
        return None
    return Run(now, 1) if run is None else replace(run, samples=run.samples + 1)
