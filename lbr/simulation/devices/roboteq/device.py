"""An emulated Roboteq SDC21xx motor controller: bytes in, bytes out, no I/O.

The manual leaves gaps. This device assumes: it refuses invalid commands with `-`, and they change nothing. Invalid are
a value outside -1000..1000, an unknown command, a wrong number of arguments and a bare prefix. A refused command does
not feed the watchdog. While the emergency stop is latched, motor commands are answered `+` and stored without effect.
An empty line and `#` get no answer. Commands take effect with their last byte, and only answers take wire time.
"""

from collections.abc import Callable, Sequence

from msgspec import Struct

from lbr.simulation.ascii_device import AsciiDevice
from lbr.simulation.devices.roboteq import RoboteqFaults
from lbr.simulation.devices.roboteq.power_stage import DEFAULT_WATCHDOG_MS, FULL, PowerStage
from lbr.simulation.wire import strikes

REBOOT_S = 0.5

_RESET_KEY = 321_654_987
_HISTORY = 16
_FACTORY = {"RWD": DEFAULT_WATCHDOG_MS, "MXMD": 0, "ECHOF": 0}
_LIMITS = {"RWD": 65_000, "MXMD": 2, "ECHOF": 1}
_IDENTITY = {"FID": "Roboteq v1.8 SDC2130 08/20/2016", "TRN": "RCB500:SDC2130"}


class Measured(Struct, frozen=True, kw_only=True):
    """The measurements of the controller. Counts, amps and rpm are per channel, in the channel's own sense: positive
    for a positive command."""

    battery_v: float = 12.6
    internal_v: float = 12.0
    output_v: float = 5.0
    amps_a: tuple[float, float] = (0.0, 0.0)
    battery_amps_a: tuple[float, float] = (0.0, 0.0)
    counts: tuple[int, int] = (0, 0)
    speeds_rpm: tuple[float, float] = (0.0, 0.0)
    temperature_c: float = 28.0

    def registers(self) -> dict[str, tuple[int, ...]]:
        """Return the answers to the queries V, A, BA, T and S, in the controller's units."""
        warm = round(self.temperature_c)
        return {
            "V": (round(self.internal_v * 10), round(self.battery_v * 10), round(self.output_v * 1000)),
            "A": tuple(round(amps * 10) for amps in self.amps_a),
            "BA": tuple(round(amps * 10) for amps in self.battery_amps_a),
            "T": (warm, warm + 2, warm + 2),
            "S": tuple(round(speed) for speed in self.speeds_rpm),
        }


class RoboteqDevice(AsciiDevice[RoboteqFaults]):
    """The controller from power-up on; `on_command` is called with each runtime command line after its effect."""

    def __init__(
        self,
        *,
        faults: RoboteqFaults | None = None,
        seed: int = 0,
        on_command: Callable[[str, float], None] | None = None,
    ) -> None:
        self.measured = Measured()
        self._on_command = on_command
        self._saved = dict(_FACTORY)
        self._away = (0.0, 0.0)
        self._now = 0.0
        self._repeat_s = 0.0
        self._repeat_at = 0.0
        super().__init__(faults or RoboteqFaults(), seed)

    def feed(self, data: bytes, now: float) -> bytes:
        """Receive bytes from the host; return the bytes that have crossed the line back so far."""
        self._now = now
        if self.present(now):
            self._stage.expired(now)
            self.receive(data, now)
        return self.poll(now)

    def poll(self, now: float) -> bytes:
        """Return the bytes that have crossed the line to the host so far."""
        self._now = now
        self._stage.expired(now)
        if self._faults.brown_out:
            self.outbox.clear()
        while self._repeat_s > 0 and now >= self._repeat_at:
            self._repeat_at = max(self._repeat_at + self._repeat_s, now - 10 * self._repeat_s)
            self._repeat_next(now)
        return self.outbox.due(now)

    def next_due(self) -> float | None:
        """Return when this device next acts by itself: an answer, a repeat, the watchdog."""
        repeat = self._repeat_at if self._repeat_s > 0 and self._history else None
        times = (self.outbox.next_due(), self._stage.expires_at(), repeat)
        return min((at for at in times if at is not None), default=None)

    def present(self, now: float) -> bool:
        """Return whether the host sees the port: not while unplugged, without power or restarting."""
        gone, back = self._away
        return not (self._faults.unplug or self._faults.brown_out or gone <= now < back)

    def outputs(self, now: float) -> tuple[float, float]:
        """Return both channels' power, -1 to 1; zero while latched, expired, faulty or without power."""
        if self._power_stage_off() or self._away[0] <= now < self._away[1]:
            return (0.0, 0.0)
        return self._stage.outputs(now)

    def cause(self, now: float) -> str:
        """Return the cause of the outputs: command, watchdog, emergency_stop, reset or fault."""
        if self._power_stage_off():
            return "fault"
        if self._stage.latched:
            return "emergency_stop"
        if self._fresh:
            return "reset"
        return "watchdog" if self._stage.expired(now) else "command"

    def _power_stage_off(self) -> bool:
        return self._faults.brown_out or self._faults.undervoltage or self._faults.overheat

    def boot(self) -> None:
        """Start with the saved settings; all other state is reset."""
        super().boot()
        self._stage = PowerStage(lambda: not self._faults.no_watchdog)
        self._stage.watchdog_ms = self._saved["RWD"]
        self._stage.mixing = self._saved["MXMD"]
        self.echo = not self._saved["ECHOF"]
        self._history: list[str] = []
        self._repeat_s = 0.0
        self._fresh = True
        self._count_zero = [0, 0]

    # Lines to meaning.

    def execute(self, line: str, now: float) -> None:
        """Carry out a line, and answer."""
        if not line:
            return
        kind, rest = line[0], line[1:].upper()
        if kind == "#":
            self._repeat(rest.split(), now)
        elif kind == "?":
            self._history = [*(q for q in self._history if q != rest), rest][-_HISTORY:]
            self.answer(self._query(rest), now)
        elif kind == "~":
            self.answer(self._read_setting(rest.split()), now)
        else:
            act = {"!": self._runtime, "^": self._configure, "%": self._maintain}.get(kind)
            obeyed = act is not None and not strikes(self._faults.refuse, self.random) and act(rest, now)
            self.answer("+" if obeyed else "-", now)
        if kind == "!" and self._on_command:
            self._on_command(line, now)

    def _runtime(self, rest: str, now: float) -> bool:
        name, numbers = _split(rest)
        if numbers is None or not self._obey(name, numbers):
            return False
        self._stage.feed(now)
        self._fresh = False
        return True

    def _obey(self, name: str, numbers: Sequence[int]) -> bool:
        stage = self._stage
        match name, numbers:
            case "M", [first, second] if _in_scale(first) and _in_scale(second):
                stage.commands = [first, second]
            case "G", [1 | 2 as channel, value] if _in_scale(value):
                stage.commands[channel - 1] = value
            case "MS", [1 | 2 as channel]:
                stage.commands[channel - 1] = 0
            case "EX", []:
                stage.latched = True
            case "MG", []:
                stage.latched = False
            case "C", [1 | 2 as channel, value]:
                self._count_zero[channel - 1] = self.measured.counts[channel - 1] - value
            case "D0" | "D1" | "DS", [_]:
                pass  # digital outputs: nothing is wired to them, but the watchdog is fed all the same
            case _:
                return False
        return True

    def _configure(self, rest: str, _now: float) -> bool:
        name, numbers = _split(rest)
        if name not in _LIMITS or numbers is None or len(numbers) != 1 or not 0 <= numbers[0] <= _LIMITS[name]:
            return False
        self._apply(name, numbers[0])
        return True

    def _apply(self, name: str, value: int) -> None:
        match name:
            case "RWD":
                self._stage.watchdog_ms = value
            case "MXMD":
                self._stage.mixing = value
            case _:
                self.echo = not value

    def _settings(self) -> dict[str, int]:
        return {"RWD": self._stage.watchdog_ms, "MXMD": self._stage.mixing, "ECHOF": int(not self.echo)}

    def _read_setting(self, words: Sequence[str]) -> str:
        settings = self._settings()
        return f"{words[0]}={settings[words[0]]}" if words and words[0] in settings else "-"

    def _maintain(self, rest: str, now: float) -> bool:
        name, numbers = _split(rest)
        if name == "EESAV" and not numbers:
            self._saved = self._settings()
            return True
        if name == "RESET" and numbers == [_RESET_KEY]:
            self.boot()
            self._away = (now, now + REBOOT_S)
            self.outbox.clear()
            return True
        return False

    def _repeat(self, words: Sequence[str], now: float) -> None:
        if words == ["C"]:
            self._history.clear()
        period_ms = int(words[0]) if len(words) == 1 and words[0].isdigit() and len(words[0]) < 6 else 0
        self._repeat_s = period_ms / 1000
        self._repeat_at = now + self._repeat_s

    def _repeat_next(self, now: float) -> None:
        if self._history and self.present(now):
            self._history.append(self._history.pop(0))
            self.answer(self._query(self._history[-1]), now)

    # Queries.

    def _query(self, rest: str) -> str:
        words = rest.split()
        if not words or len(words) > 2:
            return "-"
        if words[0] in _IDENTITY:
            return f"{words[0]}={_IDENTITY[words[0]]}"
        values = self._states().get(words[0]) or self.measured.registers().get(words[0])
        if values is None:
            return "-"
        if len(words) > 1:
            index = int(words[1]) if words[1] in "123456789" else 0
            values = values[index - 1 : index] if 1 <= index <= len(values) else ()
        return f"{words[0]}={':'.join(str(value) for value in values)}" if values else "-"

    def _states(self) -> dict[str, tuple[int, ...]]:
        faults, latched = self._faults, self._stage.latched
        off = self._power_stage_off() or latched
        first, second = self.outputs(self._now)
        counts = [count - zero for count, zero in zip(self.measured.counts, self._count_zero, strict=True)]
        return {
            "FF": (faults.overheat | faults.undervoltage << 2 | latched << 4,),
            "FS": (1 | off << 3,),
            "FM": (0, 0),
            "M": (round(FULL * first), round(FULL * second)),
            "C": tuple(counts),
        }


def _split(rest: str) -> tuple[str, list[int] | None]:
    """Return the name and its integer arguments, or None for other arguments."""
    name, *words = rest.split() or [""]
    if any(len(word) > 10 for word in words):
        return name, None
    try:
        return name, [int(word) for word in words]
    except ValueError:
        return name, None


def _in_scale(value: int) -> bool:
    return -FULL <= value <= FULL
