"""Power as a capability: readings in, a state out once a second, and the tasks of the decision."""

from math import ceil, inf, isfinite

from lbr.capability.base import Capability
from lbr.capability.context import Call, Context
from lbr.messages.calibration import CalibrationValue, measured, values
from lbr.messages.leases import CommandReply
from lbr.messages.power import ArmCommand, CancelCommand, PowerState, UpsState
from lbr.messages.speech import SayCommand
from lbr.operations.power import PowerSettings
from lbr.operations.power.logind import Answer, Logind, Question
from lbr.operations.power.parking import Parking
from lbr.operations.power.state import Answered, Arm, Cancel, Event, News, Parked, Reading, Task, Tick
from lbr.operations.power.watch import begin, code, decide, refusal

PUBLISH_S = 1.0
SAY_WITHIN_S = 2.0
ASK_AGAIN_S = 60.0
REPLY_S = 0.7
"""The wait of an arming sender for logind's answer about powering off."""
ACTING_HZ, WATCHING_HZ = 20.0, 5.0
SPOKEN = frozenset({"supply_low", "shutdown_countdown", "shutdown_failed"})
REPEATED = frozenset({"supply_low", "supply_good", "supply_unknown", "supply_known"})
"""News that a voltage between two thresholds, or a bad cable, repeats again and again."""


class Power(Capability[PowerSettings]):
    """Watches the supply, warns people, and shuts the computer down in time once it is armed."""

    rate_hz = ACTING_HZ

    def __init__(self, ctx: Context[PowerSettings]) -> None:
        super().__init__(ctx)
        self._ups: UpsState | None = None
        self._logind: Logind | None = None
        self._can = ""
        self._can_trouble = ""
        self._ask_at = inf
        self._waiting: list[tuple[Call, float]] = []
        self._parking: Parking | None = None
        self._shown: PowerState | None = None
        self._publish_at = -inf
        self._published_at: dict[str, float] = {}
        self._health = ""
        armed, warn_v, shutdown_v = self._stored_thresholds()
        self._watch = begin(armed=armed, warn_v=warn_v, shutdown_v=shutdown_v, now=ctx.clock())

    def open(self) -> None:
        """Ask whether the computer may be powered off, if that is armed."""
        if self._watch.armed:
            self._ask_at = self.ctx.clock()

    def step(self) -> None:
        """Process readings and answers, and continue parking."""
        for received in self.ctx.take("ups"):
            self._ups = received.message
            self._happen(Reading(received.message), received.arrived)
        if self._logind is not None:
            for answer in self._logind.answers():
                self._take_answer(answer)
        if self._parking is not None:
            self._parking.step()
            if self._parking.done:
                self._happen(Parked(self._parking.trouble))
        self._happen(Tick())
        if self.ctx.clock() >= self._ask_at and self._ups is not None:
            self._ask_can()
        self._reply()
        self._publish()
        self.rate_hz = WATCHING_HZ if self._watch.phase in {"watching", "disarmed"} else ACTING_HZ

    def command(self, call: Call) -> None:
        """Arm, disarm or cancel."""
        event: Arm | Cancel
        if isinstance(call.message, ArmCommand):
            event = Arm(call.message.armed, call.message.warn_v, call.message.shutdown_v, call.source)
        elif isinstance(call.message, CancelCommand):
            event = Cancel(call.source + (f" ({call.message.reason})" if call.message.reason else ""))
        else:
            super().command(call)
            return
        why_not = refusal(self._watch, event)
        if why_not:
            call.refuse(why_not, "not_possible")
            return
        self._happen(event)
        if isinstance(event, Arm) and event.armed:
            self._waiting.append((call, self.ctx.clock() + REPLY_S))
        else:
            call.reply(CommandReply(accepted=True, reason=self._watch.reason))
        self._publish()

    def close(self) -> None:
        """Stop questions and parking."""
        self._stop_parking()
        for call, _ in self._waiting:
            call.reply(CommandReply(accepted=True, reason=self._summary()))
        self._waiting.clear()
        logind, self._logind = self._logind, None
        if logind is not None:
            logind.close()

    def _stored_thresholds(self) -> tuple[bool, float, float]:
        """Return the stored thresholds, or else the settings; impossible numbers are reported and ignored."""
        stored, settings = values(self.ctx.rows(CalibrationValue)), self.ctx.settings
        warn_v, shutdown_v = stored.get("warn_v", settings.warn_v), stored.get("shutdown_v", settings.shutdown_v)
        if not (isfinite(warn_v) and 0.0 < shutdown_v <= warn_v <= 100.0):
            text = f"thresholds {warn_v:g} V and {shutdown_v:g} V beside device '{settings.device}' cannot be used; "
            text += f"{settings.warn_v:g} V and {settings.shutdown_v:g} V are, until it is armed again"
            self.ctx.event("thresholds_unusable", text, level="warning")
            warn_v, shutdown_v = settings.warn_v, settings.shutdown_v
        return stored.get("armed", float(settings.armed)) != 0.0, warn_v, shutdown_v

    def _happen(self, event: Event, at: float | None = None) -> None:
        self._watch, tasks = decide(self._watch, event, self.ctx.clock() if at is None else at, self.ctx.settings)
        for task in tasks:
            if isinstance(task, News):
                self._tell(task)
            else:
                self._do(task)

    def _do(self, task: Task) -> None:
        watch = self._watch
        match task:
            case "park":
                self._parking = Parking(self.ctx)
            case "stop_parking":
                self._stop_parking()
            case "power_off" if self._pretends:
                self._happen(Answered(pretended=True))
            case "power_off":
                self._ask("PowerOff")
            case "ask_can":
                self._can = self._can_trouble = ""
                self._ask_at = self.ctx.clock()
            case "keep":
                kept = {"armed": float(watch.armed), "warn_v": watch.warn_v, "shutdown_v": watch.shutdown_v}
                self.ctx.learn(*measured(self.ctx.settings.device, kept))

    def _stop_parking(self) -> None:
        parking, self._parking = self._parking, None
        if parking is not None:
            parking.stop()

    @property
    def _pretends(self) -> bool:
        """Return whether the supply cannot fail: a twin must never power off the computer on which it runs."""
        return not self.ctx.settings.bus and (self._ups is None or self._ups.emulated)

    def _ask(self, question: Question) -> None:
        if self._logind is None:
            self._logind = Logind(self.ctx.settings.bus, self.ctx.settings.answer_s, self.ctx.wake)
        self._logind.ask(question)

    def _ask_can(self) -> None:
        """Ask whether the computer may be powered off, and again later if it may not."""
        self._ask_at = inf
        if self._pretends:
            self._take_answer(Answer("CanPowerOff", "not asked, because the supply is emulated"))
        else:
            self._ask("CanPowerOff")

    def _take_answer(self, answer: Answer) -> None:
        if answer.question == "PowerOff":
            self._happen(Answered(answer.trouble))
            return
        if answer.trouble:
            self._ask_at = self.ctx.clock() + ASK_AGAIN_S
            if answer.trouble != self._can_trouble:
                text = f"this computer cannot be powered off from here: {answer.trouble}"
                self.ctx.event("power_off_denied", text, level="warning")
        self._can, self._can_trouble = answer.word or "unknown", answer.trouble

    def _reply(self) -> None:
        """Reply to arming senders, once logind's answer is known."""
        now = self.ctx.clock()
        due = [(call, until) for call, until in self._waiting if self._can or now >= until]
        for call, until in due:
            self._waiting.remove((call, until))
            call.reply(CommandReply(accepted=True, reason=self._summary()))

    def _tell(self, news: News) -> None:
        now = self.ctx.clock()
        if news.kind in REPEATED and now - self._published_at.get(news.kind, -inf) < self.ctx.settings.repeat_s:
            return
        self._published_at[news.kind] = now
        self.ctx.event(news.kind, news.text, level=news.level, code="done" if news.about else "", about=news.about)
        if news.kind in SPOKEN and self.ctx.targets("say"):
            self.ctx.ask("say", SayCommand(text=news.text), timeout_s=SAY_WITHIN_S)  # speech reports its own errors

    def _publish(self) -> None:
        now, before = self.ctx.clock(), self._shown
        state = self._state(now)
        if before is None or _gist(state) != _gist(before) or now >= self._publish_at:
            self._shown, self._publish_at = state, now + PUBLISH_S
            self.ctx.publish("state", state)
        health = self._unwell()
        if bool(health) != bool(self._health):
            self.ctx.warn(health, "not_possible") if health else self.ctx.ready()
        self._health = health

    def _state(self, now: float) -> PowerState:
        watch = self._watch
        counts = watch.phase == "countdown"
        return PowerState(
            phase=watch.phase,
            armed=watch.armed,
            warn_v=watch.warn_v,
            shutdown_v=watch.shutdown_v,
            reason=watch.reason,
            code=code(watch),
            remaining_s=float(ceil(max(0.0, watch.until_s - now))) if counts else None,
            can_power_off=f"{self._can}: {self._can_trouble}" if self._can_trouble else self._can,
            ups=self._ups,
        )

    def _unwell(self) -> str:
        """Return why this capability does not work as it should, or an empty string."""
        watch = self._watch
        if watch.phase == "failed":
            return watch.reason
        if watch.silent:
            return watch.view.trouble
        return self._can_trouble if watch.armed else ""

    def _summary(self) -> str:
        watch = self._watch
        trouble = f"; but {self._can_trouble}" if self._can_trouble else ""
        return f"armed: warns below {watch.warn_v:g} V, shuts down below {watch.shutdown_v:g} V{trouble}"


def _gist(state: PowerState) -> tuple[object, ...]:
    return (state.phase, state.armed, state.warn_v, state.shutdown_v, state.remaining_s, state.can_power_off, state.ups)
