"""A humanoid of six joints for tests: its rows, servos that follow what they are told, and the kernel between them."""

from math import nan

from msgspec.structs import replace

from lbr.leases.lease import EstopChanged, Happened, Reply, Result, Setpoint, Stop
from lbr.messages.codes import MEANINGS
from lbr.messages.joints import Joint, JointsCommand, KeyFrame, TorqueCommand
from lbr.messages.servos import ServosState, ServoState, StoredState
from lbr.operations.joints.body import body
from lbr.operations.joints.kernel import decide
from lbr.operations.joints.settings import JointsSettings
from lbr.operations.joints.state import Command, HolderGone, ServosLost, ServosSeen, Tick, Torque, first_state


def pair(name, first_id, sign, zero_rad, lower_rad, upper_rad, speed_rps=2.0):
    limits = {"lower_rad": lower_rad, "upper_rad": upper_rad, "speed_rps": speed_rps}
    return (
        Joint(name=f"right_{name}", device_id=first_id, side="right", sign=sign, zero_rad=zero_rad, **limits),
        Joint(name=f"left_{name}", device_id=first_id + 1, side="left", sign=-sign, zero_rad=-zero_rad, **limits),
    )


ROWS = (
    *pair("shoulder_pitch", 1, 1, -1.5, -0.5, 2.5),
    *pair("knee", 13, 1, 0.0, -2.0, 0.1),
    Joint(name="head_yaw", device_id=20, lower_rad=-1.0, upper_rad=0.8, speed_rps=1.0),
    Joint(name="right_grip", device_id=21, side="right", lower_rad=0.0, upper_rad=1.0, speed_rps=2.0),
)
BODY = body(ROWS)
NAMES = tuple(BODY.joints)
START = 100.0
DT = 0.01


class Servos:
    """What the servos' driver would say: each servo goes a share of its way, if it has torque and is well."""

    def __init__(self, share=1.0):
        self.share = share
        self.at = {joint.device_id: joint.zero_rad for joint in ROWS}
        self.torque = dict.fromkeys(self.at, 0.0)
        self.latched = {}
        self.missing = set()
        self.stuck = set()
        self.powerless = {}
        self.unread = False
        self.ages_s = {}
        self.held_at = {}
        self.phase = "released"
        self.armed, self.reason, self.code, self.estop, self.rests = True, "", "", False, False
        self.sweep = 0
        self.stores, self.stored, self.mode = False, None, ""
        self.doubted = set()
        self.tells_torque, self.told = True, set()

    def obey(self, setpoint):
        self._play(setpoint)
        if setpoint.lost:
            self.phase = "holding" if any(self.torque.values()) else "released"
            return
        self.told |= {goal.id for goal in setpoint.goals if goal.torque > 0.0}
        for goal in setpoint.goals:
            self.torque[goal.id] = 0.0 if goal.id in self.latched else goal.torque
            moves = self.torque[goal.id] > 0.0 and goal.position_rad is not None and goal.id not in self.stuck
            if moves:
                self.at[goal.id] += (goal.position_rad - self.at[goal.id]) * self.share
        self.phase = "following" if any(self.torque.values()) else "released"

    def _play(self, setpoint):
        """A controller that plays from the first setpoint on that says so, until it is told that this is over."""
        asked = setpoint.stored
        if not self.stores or asked is None or (self.stored and self.stored.count >= asked.count):
            return
        self.stored = StoredState(slot=asked.slot, count=asked.count, phase="playing")

    def plays(self, phase, reason=""):
        """Have the controller say so of what it was told last."""
        self.stored = replace(self.stored, phase=phase, reason=reason)

    def released_at(self):
        self.torque = dict.fromkeys(self.at, 0.0)
        self.phase = "released"

    def state(self, now):
        self.sweep += 1
        return ServosState(
            sweep=self.sweep,
            measured_s=now,
            armed=self.armed,
            phase=self.phase,
            servos=tuple(self._servo(servo) for servo in self.at),
            reason=self.reason,
            code=self.code,
            estop=self.estop,
            rests=self.rests,
            stores=self.stores,
            stored=self.stored,
            mode=self.mode,
            tells_torque=self.tells_torque,
        )

    def _servo(self, servo):
        if self.unread:
            return ServoState(id=servo)
        if servo in self.missing:
            return ServoState(id=servo, reason=f"servo {servo} does not answer")
        return ServoState(
            id=servo,
            position_rad=None if servo in self.doubted else self.at[servo],
            trusted=False if servo in self.doubted else None,
            torque=self._torque(servo),
            goal_rad=self.held_at.get(servo),
            latched=self.latched.get(servo, ()),
            age_s=self.ages_s.get(servo, 0.0),
            reason=self.powerless.get(servo, ""),
        )

    def _torque(self, servo):
        if not (self.tells_torque or servo in self.told):
            return None
        return 0.0 if servo in self.powerless else self.torque[servo]


class Bench:
    """The kernel in its loop: 100 rounds a second, with a sweep of the servos in each."""

    def __init__(self, **settings):
        self.settings = JointsSettings(**settings)
        self.servos = Servos()
        self.now = START
        self.said = []
        self.results = []
        self.events = []
        self.setpoint = None
        self.restart()

    def restart(self):
        self.state = first_state(self.settings, BODY)
        self.setpoint = None

    def give(self, event):
        """Have an event decided; return what was said."""
        self.state, outputs = decide(self.state, event, self.now)
        self.said += outputs
        for output in outputs:
            if isinstance(output, Setpoint):
                self.setpoint = output.message
                self.servos.obey(output.message)
            elif isinstance(output, Result):
                assert output.message.code in MEANINGS, output
                self.results.append(output.message)
            elif isinstance(output, Happened):
                self.events.append(output)
        return outputs

    def hear(self):
        return self.give(ServosSeen(servos=self.servos.state(self.now), arrived=self.now))

    def run(self, seconds, lease="", *, hear=True):
        """Let time pass; a lease is renewed at 10 Hz."""
        for round_ in range(round(seconds / DT)):
            self.now = round(self.now + DT, 6)
            if hear:
                self.hear()
            if lease and round_ % 10 == 0:
                self.command(lease=lease)
            self.give(Tick())
        return self

    def standing(self):
        """With torque everywhere."""
        self.run(0.05)
        assert self.torque(on=True).accepted
        return self.run(0.05)

    def command(self, positions=None, *, source="console", received=nan, **more):
        """Ask for a motion, and return the answer."""
        remote = {name: more.pop(name) for name in ("remote", "sender_s", "answerable") if name in more}
        event = Command(
            command=JointsCommand(positions=positions or {}, **more),
            source=source,
            new_lease=f"lease-{len(self.said)}",
            new_goal=f"goal-{len(self.said)}",
            received=self.now if received != received else received,
            **remote,
        )
        return self.answer(event)

    def torque(self, *joints, on, source="console", **more):
        command = TorqueCommand(on=on, joints=joints, **more)
        return self.answer(Torque(command=command, source=source, received=self.now))

    def stop(self, source="phone"):
        return self.answer(Stop(source=source, received=self.now, reason="test"))

    def answer(self, event):
        (reply,) = (output.message for output in self.give(event) if isinstance(output, Reply))
        assert reply.accepted or reply.code in MEANINGS, reply
        return reply

    def estop(self, *, engaged=True):
        return self.give(EstopChanged(engaged=engaged, reason="test"))

    def lose_servos(self):
        return self.give(ServosLost(reason="the servo driver (servos) is gone"))

    def lose_holder(self, source="console"):
        return self.give(HolderGone(source=source))

    def set(self, **changes):
        self.state = replace(self.state, **changes)

    @property
    def goals(self):
        """Where the joints were told to be last; those without torque are left out."""
        by_id = {joint.device_id: name for name, joint in BODY.joints.items()}
        told = {by_id[goal.id]: goal for goal in self.setpoint.goals if goal.torque > 0.0}
        return {
            name: None if goal.position_rad is None else BODY.joint_rad(name, goal.position_rad)
            for name, goal in told.items()
        }

    def measured(self, name):
        return BODY.joint_rad(name, self.servos.at[BODY.joints[name].device_id])

    def push(self, name, joint_rad):
        self.servos.at[BODY.joints[name].device_id] = BODY.servo_rad(name, joint_rad)


def frame(duration_s=0.5, **positions):
    return KeyFrame(positions=positions, duration_s=duration_s)
