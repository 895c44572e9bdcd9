"""Commands that the line answers: PC control, questions, and the configuration of servos behind its switch."""

from collections.abc import Mapping
from concurrent.futures import Future

from lbr.capability.context import Call, Context
from lbr.drivers.servos.bus_thread import READ, STOP
from lbr.messages.codes import Reason
from lbr.messages.leases import CommandReply
from lbr.robots.uxa90.driver import Uxa90Settings
from lbr.robots.uxa90.driver.frames import QUESTIONS, TAKE_CONTROL
from lbr.robots.uxa90.driver.messages import ConfigureCommand, InquireCommand, InquireReply
from lbr.robots.uxa90.driver.requests import configuration, inquiry
from lbr.robots.uxa90.driver.session import Session

PROVEN_S = 1.0
"""The age of a servo's answer that proves that packets are passed on."""
TAKEN_S = 5.0
MOST_WAITING = 16


class Commands:
    """The calls that wait for the line, in the loop's thread."""

    def __init__(self, ctx: Context[Uxa90Settings], joints: Mapping[int, str]) -> None:
        self._ctx = ctx
        self._servos = tuple(joints)
        self._asked: list[tuple[Call, Future[InquireReply]]] = []
        self._taking: list[tuple[Call, float]] = []

    def take_control(self, call: Call, session: Session) -> None:
        """Take PC control; the reply comes after that."""
        controller = session.controller
        if busy := _busy(session):
            call.refuse(busy, "busy")
            return
        if controller.mode.pc and self._ctx.clock() - session.poller.heard_at < PROVEN_S:
            session.thread.submit(lambda bus: bus.say(TAKE_CONTROL), STOP, "control")  # on request; without a pause
        else:
            controller.take(again=True)
        self._taking.append((call, self._ctx.clock() + TAKEN_S))

    def ask(self, call: Call, session: Session, *, moving: bool) -> None:
        """Ask or configure a servo, or ask the main board."""
        message = call.message
        try:
            if isinstance(message, InquireCommand):
                refused = _not_askable(message, session)
                job = inquiry(message, self._servos)
            elif isinstance(message, ConfigureCommand):
                refused = self._not_configurable(session, moving=moving)
                job = configuration(message, self._servos)
            else:
                call.refuse(f"{call.name} is not understood here", "unknown_command")
                return
        except ValueError as err:
            refused = Reason("unknown_name", str(err))
        if refused or len(self._asked) >= MOST_WAITING:
            why = refused or Reason("busy", "too many questions wait; ask later")
            call.reply(InquireReply(accepted=False, reason=why.text, code=why.code))
            return
        self._asked.append((call, session.thread.submit(job, READ)))

    def step(self, session: Session) -> None:
        """Reply to the finished calls."""
        now, taking, asked = self._ctx.clock(), [], []
        for call, until in self._taking:
            if session.controller.mode.pc:
                note = "" if session.controller.mode.answered else "the main board did not say so itself"
                call.reply(CommandReply(accepted=True, reason=note))
            elif now >= until:
                call.refuse("PC control was not taken in time", "timeout")
            else:
                taking.append((call, until))
        for call, future in self._asked:
            if not future.done():
                asked.append((call, future))
            elif future.cancelled() or future.exception() is not None:
                call.reply(InquireReply(accepted=False, reason="the line went away", code="unreachable"))
            else:
                call.reply(future.result())
        self._taking, self._asked = taking, asked

    def refuse(self, reason: str) -> None:
        """Refuse all calls, because the line is gone."""
        for call, _ in self._taking:
            call.refuse(reason, "unreachable")
        for call, _ in self._asked:
            call.reply(InquireReply(accepted=False, reason=reason, code="unreachable"))
        self._taking, self._asked = [], []

    def _not_configurable(self, session: Session, *, moving: bool) -> Reason | None:
        if not self._ctx.settings.maintenance:
            return Reason(
                "not_possible",
                f'servos\' registers are written only in maintenance: set "maintenance": true in the settings '
                f"of the capability row '{self._ctx.name}', and take it out again afterwards",
            )
        return Reason("busy", "the joints are being moved; stop that first") if moving else _not_passed(session)


def _not_askable(message: InquireCommand, session: Session) -> Reason | None:
    busy = _busy(session)
    return (Reason("busy", busy) if busy else None) if message.what in QUESTIONS else _not_passed(session)


def _not_passed(session: Session) -> Reason | None:
    if busy := _busy(session):
        return Reason("busy", busy)
    return None if session.controller.mode.pc else Reason("not_ready", "PC control is not taken yet; ask again")


def _busy(session: Session) -> str:
    controller = session.controller
    if not controller.occupied or controller.plays.asked is None:
        return ""
    return f"busy: the main board plays its motion {controller.plays.asked.slot}, {controller.left_s:.1f} s are left"
