"""A robot around one attitude capability, for tests: a made-up inertial unit, and a drive that turns it."""

from dataclasses import dataclass, field

from lbr.messages.attitude import CalibrateCommand, ObserveCommand
from lbr.messages.calibration import values
from lbr.messages.codes import Reason
from lbr.messages.drive import DriveCommand
from lbr.messages.leases import CommandReply, StopCommand, refused
from lbr.operations.attitude import KIND
from lbr.operations.attitude.capability import Attitude
from lbr.operations.attitude.settings import AttitudeSettings
from lbr.testing import FakeCall, FakeContext
from tests.operations.attitude.imu_bench import MadeUpImu
from tests.support.replies import dead

TURN_DPS = 400.0
"""How fast the made-up base spins at full power."""


@dataclass
class FakeDrive:
    """Turns as asked for as long as its lease is renewed; `refuses` says why not, `mute` never answers."""

    refuses: str = ""
    mute: bool = False
    absent: bool = False
    lease: str = ""
    leases: int = 0
    power: float = 0.0
    until_s: float = 0.0
    commands: list[tuple[float, DriveCommand]] = field(default_factory=list)
    stops: list[str] = field(default_factory=list)

    def answer(self, request, message, now):
        if self.absent:
            return {}
        if self.mute:
            return None
        if request == "halt":
            self.stops.append(message.reason)
            self.lease, self.power = "", 0.0
            return {"drive": CommandReply(accepted=True)}
        self.commands.append((now, message))
        lapsed = message.lease and (message.lease != self.lease or now > self.until_s)
        if self.refuses or lapsed:
            return {
                "drive": refused(Reason("held", self.refuses))
                if self.refuses
                else dead("stopped by console", "stopped")
            }
        if not message.lease:
            self.leases += 1
            self.lease = f"lease-{self.leases}"
        self.until_s = now + 0.3
        self.power = message.power if message.angle_deg == 90.0 else -message.power
        return {"drive": CommandReply(accepted=True, lease=self.lease, ttl_s=0.3)}

    def rate_dps(self, now):
        return self.power * TURN_DPS if self.lease and now <= self.until_s else 0.0


class AttitudeContext(FakeContext):
    """The context of an attitude; `run` lets time pass for it, its inertial unit and its drive."""

    def __init__(self, home, imu=None, wired=None, **settings):
        self.imu = imu or MadeUpImu()
        given = {"name": "attitude", "home": str(home), "wired": wired or {}}
        super().__init__(KIND, AttitudeSettings(device="imu", **settings), **given)
        self.drive = FakeDrive()
        self.deaf = False
        self.capability = Attitude(self)
        self.capability.open()

    def clock(self):
        return self.imu.time_s

    def answer(self, request, message):
        return self.drive.answer(request, message, self.clock())

    @property
    def calibration(self):
        """What was measured on the device."""
        return values(self.given)

    def learn(self, *rows):
        """Keep the numbers by their names."""
        super().learn(*rows)
        self.kept[-1] = values(rows)

    def run(self, seconds, until=lambda: False):
        """Let the base turn, the inertial unit measure at 100 Hz and the capability step at 50 Hz."""
        for _ in range(round(seconds * 50)):
            for _ in range(2):
                sample = self.imu.sample(self.drive.rate_dps(self.clock()))
                if not self.deaf:
                    self.arrive("samples", sample)
            self.capability.step()
            if until():
                return
        assert not until() or seconds == 0

    def say(self, name, message):
        call = FakeCall(name, message, arrived=self.clock())
        self.capability.command(call)
        return call

    def calibrate(self, samples=100, source="-"):
        return self.say("calibrate", CalibrateCommand(samples=samples, source=source))

    def observe(self, angle_deg):
        return self.say("observe", ObserveCommand(angle_deg=angle_deg))

    def stop(self, *, whole=False):
        return self.say("stop", StopCommand(whole=whole))

    def state(self):
        return self.said("state")[-1]
