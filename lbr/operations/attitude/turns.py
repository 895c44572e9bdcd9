"""The requests to report a turn of the body. No I/O, and no effect on motion."""

from dataclasses import dataclass

from lbr.messages.attitude import AttitudeState

MOST = 16


@dataclass(frozen=True, slots=True)
class TurnReport:
    """The report about one request: `kind` is `turned`, or `turn_lost` if it was given up."""

    kind: str
    text: str
    data: dict[str, float]


@dataclass(frozen=True, slots=True)
class _Turn:
    angle_deg: float
    from_deg: float
    since_s: float
    epoch: str


class Turns:
    """Stores requests by `watch`; `look` returns their reports."""

    def __init__(self, longest_s: float) -> None:
        self._longest_s = longest_s
        self._turns: list[_Turn] = []

    def watch(self, angle_deg: float, state: AttitudeState, now: float) -> str:
        """Store a request for a turn by an angle, clockwise positive; return why it is refused, or an empty string."""
        if angle_deg == 0.0:
            return "0 degrees is no turn; say how far, -360 to 360, clockwise positive"
        if not state.valid or state.turned_deg is None:
            return f"how far the body turns is not known: {state.reason}"
        if len(self._turns) >= MOST:
            return f"{MOST} turns are watched already; one of them has to end first"
        self._turns.append(_Turn(angle_deg, state.turned_deg, now, state.epoch))
        return ""

    def look(self, state: AttitudeState, now: float) -> list[TurnReport]:
        """Return the reports that are due."""
        reports, waiting = [], []
        for turn in self._turns:
            report = self._judge(turn, state, now)
            if report is None:
                waiting.append(turn)
            else:
                reports.append(report)
        self._turns = waiting
        return reports

    def _judge(self, turn: _Turn, state: AttitudeState, now: float) -> TurnReport | None:
        elapsed_s = now - turn.since_s
        wanted = f"the turn of {turn.angle_deg:g} degrees"
        if state.epoch != turn.epoch:
            return _lost(turn, f"{wanted} was lost sight of: {state.reason or 'samples were missing'}")
        if state.turned_deg is not None:
            turned_deg = state.turned_deg - turn.from_deg
            if turned_deg >= turn.angle_deg if turn.angle_deg > 0.0 else turned_deg <= turn.angle_deg:
                data = {"angle_deg": turn.angle_deg, "turned_deg": turned_deg, "elapsed_s": elapsed_s}
                return TurnReport("turned", f"turned {turned_deg:.1f} degrees in {elapsed_s:.1f} s", data)
        if elapsed_s > self._longest_s:
            return _lost(turn, f"{wanted} did not come within {elapsed_s:.0f} s; it is watched no longer")
        return None


def _lost(turn: _Turn, text: str) -> TurnReport:
    return TurnReport("turn_lost", text, {"angle_deg": turn.angle_deg})
