"""A history of the model, lived through by lbr's own decisions: what they do differently is a mismatch."""

from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from math import inf, nan

from lbr.capability.send_times import SendTimes
from lbr.drivers.wheels import arming
from lbr.drivers.wheels.arming import Arming, Inhibit
from lbr.leases.lease import EstopChanged, Reply, Setpoint, Stop
from lbr.messages.drive import DriveCommand
from lbr.messages.leases import CommandReply
from lbr.messages.motors import MotorSetpoint, MotorsState
from lbr.messages.sensing import Ranges
from lbr.messages.system import Stamp
from lbr.operations.drive import kernel
from lbr.operations.drive.state import Command, Event, MotorsLost, MotorsSeen, Outputs, RangesSeen, State, Tick
from tests.models.lease.spin import DRIVE, ROBOTEQ

Decide = Callable[[State, Event, float], tuple[State, Outputs]]
SENSORS = ("forward", "back", "left", "right", "bottom")
FREE = Ranges(**{f"{name}_m": None for name in SENSORS}, status=dict.fromkeys(SENSORS, "over_range"))  # type: ignore[arg-type]
ARMED = MotorsState(left=0.0, right=0.0, armed=True, reason="", estop=False)
SOURCES = ("console", "page")
LONG_AGO = "a lease of long ago"
AHEAD_S = 1000.0
"""The clock of the other machine is ahead by so much."""
STRAIGHT, ASTRAY = 0, 1
PRESSED = EstopChanged(engaged=True, reason="button")
RESET = EstopChanged(engaged=False)


class MismatchError(AssertionError):
    """The model says one thing, lbr's decisions do another."""


@dataclass
class Driver:
    """The driver's decision, around it what its process does, and the controller with its watchdog."""

    receive: Callable[[Arming, arming.Setpoint, float, float], Arming] = arming.receive
    tick: Callable[[Arming, Inhibit | None, float, float], Arming] = arming.tick
    up: bool = True
    latched: bool = False
    turns: bool = False
    state: Arming = field(default_factory=Arming)
    _stepped: float = inf
    _fed: float = -inf
    _dates: SendTimes = field(default_factory=SendTimes)

    def begin(self, now: float, *, latched: bool) -> None:
        """Start over, with zero at the controller."""
        self.up, self.latched, self.turns = True, latched, False
        self.state, self._stepped, self._fed, self._dates = Arming(since=now), inf, now, SendTimes()
        self.step(now)

    def die(self) -> None:
        """Be killed: the controller goes on by itself."""
        self.up, self.latched = False, False

    def take(self, setpoint: MotorSetpoint, sent: tuple[float, int], now: float) -> bool:
        """Take a setpoint from the channel; return whether it came in order."""
        born, number = sent
        if not self._dates.newer(Stamp(source="drive", seq=number, mono_ns=number, wall_ns=0, boot="one")):
            return False
        valid_s = ROBOTEQ.setpoint_valid_s
        told = arming.Setpoint((setpoint.left, setpoint.right), setpoint.lease, born, begun=born)
        self.state = self.receive(self.state, told, now, valid_s)
        self.step(now)
        return True

    def step(self, now: float) -> None:
        """Go round the loop once."""
        inhibit = None
        if self.latched:
            inhibit = Inhibit("emergency stop", fault=False)
        elif now - self._stepped >= ROBOTEQ.setpoint_valid_s:
            inhibit = Inhibit("held up", fault=True)
        self.state = self.tick(self.state, inhibit, now, ROBOTEQ.setpoint_valid_s)
        self.turns, self._fed, self._stepped = self.state.moving, now, now

    def watch(self, now: float) -> None:
        """Let the controller's watchdog see the time."""
        if now - self._fed >= ROBOTEQ.watchdog_ms / 1000:
            self.turns = False


class Replay:
    """Time, lbr's drive and driver, and what is on its way between them and to them."""

    def __init__(self, tick_s: float, world: str, decide: Decide = kernel.decide, driver: Driver | None = None) -> None:
        self.now = 128.0
        self.followed = 0
        self.moved = 0
        self._tick_s = tick_s
        self._remote = "r" in world
        self._decide = decide
        self._drive = kernel.first_state(DRIVE)
        self._driver = driver or Driver()
        self._driver.step(self.now)
        self._armed = self._pressed = False
        self._leases = 0
        self._known = [LONG_AGO, LONG_AGO]
        self._message: tuple[tuple[int, DriveCommand], float] | None = None
        self._said: list[MotorSetpoint] = []
        self._sent = 0
        self._astray: tuple[MotorSetpoint, tuple[float, int]] | None = None
        self._reply: CommandReply | None = None
        self._answered = False
        self._asker = 0
        self._line = ""

    def follow(self, trace: Iterable[str]) -> None:
        """Live through a history; MismatchError says where lbr does something else than the model."""
        for line in trace:
            self._line = line
            word, *rest = line.split()
            if word == "violated":
                self._violated()
                return
            self._live(word, [int(one) for one in rest])
            self.followed += 1

    def _violated(self) -> None:
        """Say what lbr did when the model, in the end, broke what it must keep: refuse, or stand still."""
        if self._answered and self._reply is not None and not self._reply.accepted:
            raise self._mismatch(f"the drive refuses: {self._reply.reason}")
        if not self._driver.turns:
            raise self._mismatch("the motors stand still")

    def _live(self, word: str, told: list[int]) -> None:  # noqa: C901  one case for each word of a history
        driver = self._driver
        match word, told:
            case "time", [runs]:
                self._time_passes(bool(runs))
            case "tick", []:
                self._tell(Tick())
            case "says", [client, lease, moves, takes]:
                self._send(self._words(client, lease, moves, takes), self.now)
            case "astray", [client, lease, moves, takes]:
                self._message = self._words(client, lease, moves, takes), self.now
            case "comes", [again]:
                assert self._message is not None
                message, self._message = self._message, self._message if again else None
                self._send(*message)
            case "lost", []:
                self._message = None
            case "verdict", [accepted]:
                self._answered = False
                if self._reply is None or self._reply.accepted != bool(accepted):
                    raise self._mismatch(f"the drive answers {self._reply}")
            case "learns", []:
                assert self._reply is not None
                self._known[self._asker] = self._reply.lease
            case "setpoint", [moves, way]:
                self._says_setpoint(bool(moves), way)
            case "setpoint_comes", []:
                if self._astray is None or not driver.take(*self._astray, self.now):
                    raise self._mismatch("the driver takes no setpoint that was overtaken")
            case "hears", [armed]:
                gone = MotorsLost(reason="the motors are gone")
                self._tell(MotorsSeen(motors=ARMED, arrived=self.now) if armed else gone)
                self._armed = bool(armed)
            case "drive_begins", []:
                self._drive, self._armed = kernel.first_state(DRIVE, self.now), False
                self._tell(*([PRESSED] if self._pressed else []), Tick())
            case "driver_dies", []:
                driver.die()
            case "driver_begins", []:
                driver.begin(self.now, latched=self._pressed)
            case (("pressed" | "reset"), []):
                self._pressed = word == "pressed"
            case "drive_latches", [engaged]:
                self._tell(PRESSED if engaged else RESET)
            case "driver_latches", [engaged]:
                driver.latched = bool(engaged)
                driver.step(self.now)
            case "state", [held, source, moves, wheels, armed, turns]:
                self._compare((held, source, moves, wheels, armed, turns))
            case _:
                raise self._mismatch("nobody knows what this means")

    def _time_passes(self, runs: bool) -> None:
        self.now += self._tick_s
        self._driver.watch(self.now)
        if runs and self._driver.up:
            self._driver.step(self.now)

    def _words(self, client: int, lease: int, moves: int, takes: int) -> tuple[int, DriveCommand]:
        quoted = self._known[client] if lease else ""
        return client, DriveCommand(power=0.5 if moves else 0.0, lease=quoted, take_over=bool(takes))

    def _send(self, said: tuple[int, DriveCommand], sent: float) -> None:
        self._asker, command = said
        remote = self._remote and self._asker == 1
        self._leases += 1
        self._reply, self._answered = None, True
        if self._asker == 0 and command.power == 0.0 and not command.lease:
            self._tell(Stop(source=SOURCES[0], received=sent))  # the other one stops by power 0
            return
        self._tell(
            Command(
                command=command,
                source=SOURCES[self._asker],
                new_lease=f"lease {self._leases}",
                new_goal=f"goal {self._leases}",
                received=self.now if remote else sent,
                remote=remote,
                sender_s=sent + AHEAD_S if remote else nan,
            )
        )

    def _tell(self, *events: Event) -> None:
        """Tell the drive, which has just heard its sensors and, if it may believe in them, its motors."""
        if self._said:
            raise self._mismatch("the drive said a setpoint that the model knows nothing of")
        heard = [MotorsSeen(motors=ARMED, arrived=self.now)] if self._armed else []
        for event in (*heard, RangesSeen(ranges=FREE, arrived=self.now), *events):
            self._drive, outputs = self._decide(self._drive, event, self.now)
            for output in outputs:
                if isinstance(output, Setpoint):
                    self._said.append(output.message)
                elif isinstance(output, Reply):
                    self._reply = output.message

    def _says_setpoint(self, moves: bool, way: int) -> None:
        if not self._said or moves != _moves(self._said[-1]) or any(_moves(one) for one in self._said[:-1]):
            raise self._mismatch(f"the drive says {self._said}")
        self._sent += 1
        setpoint = self._said[-1], (self.now, self._sent)
        self._said = []
        if way == STRAIGHT:
            self._driver.take(*setpoint, self.now)
        elif way == ASTRAY:
            self._astray = setpoint

    def _compare(self, model: tuple[int, ...]) -> None:
        if self._said:
            raise self._mismatch(f"the drive said {self._said}, the model nothing")
        hold, driver = self._drive.lease, self._driver
        lives = (
            hold is not None,
            hold is not None and hold.source == SOURCES[1],
            hold is not None and hold.motion.command.power > 0.0,  # type: ignore[union-attr]
            self._drive.left != 0.0,
            driver.up and driver.state.armed,
            driver.turns,
        )
        if lives != tuple(bool(one) for one in model):
            names = ("held", "by the second", "to move", "wheels", "armed", "turning")
            told = ", ".join(f"{name} {int(one)}" for name, one in zip(names, lives, strict=True))
            raise self._mismatch(f"lbr has {told}")
        self.moved += driver.turns

    def _mismatch(self, what: str) -> MismatchError:
        return MismatchError(f"line {self.followed + 1}, '{self._line}': {what}")


def _moves(setpoint: MotorSetpoint) -> bool:
    return setpoint.left != 0.0 or setpoint.right != 0.0
