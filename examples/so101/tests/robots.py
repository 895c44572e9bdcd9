"""A whole SO-101 for a test: `lbr run so101-sim`, and a person's actions with it."""

import time
from contextlib import contextmanager

from lbr.testing.robot import NoAnswerError, running

SLOWLY_S = 45.0
"""Limits waiting on a busy machine; on an idle one, each wait takes a moment."""

PAUSE_S = 0.3
"""After this time a sender counts as one that has paused."""

HELD_UP = ("late", "stale_sensor")
"""Codes of a refusal on a machine that delayed a process: the line itself, or a reading that judges it."""


def until(look, what, within_s=SLOWLY_S):
    end = time.monotonic() + within_s
    while not (seen := look()):
        assert time.monotonic() < end, f"not within {within_s:g} s: {what}"
        time.sleep(0.02)
    return seen


class Arms:
    """The robot for its operator; `follower` and `leader` are the angles of the joints, by the follower's names."""

    def __init__(self, robot):
        self.robot = robot

    def say(self, line):
        """Send a line that must be accepted; repeat it if this machine delayed it or the driver too long."""
        reply = until(lambda: (said := self.robot.say(line))["reason_code"] not in HELD_UP and said, f"{line} in time")
        assert reply["code"] == 0, reply
        return reply

    def hear(self, line):
        """Send a line that may be refused; on a busy machine, only a repetition may get an answer."""
        try:
            return self.robot.say(line)
        except NoAnswerError:
            return {"code": 1, "text": "", "hold": None}

    def follow(self, condition, what):
        """Teleoperate until a condition holds; begin again if a busy machine has ended it."""

        def look():
            if self.state("teleop")["phase"] == "idle":
                self.hear("/torque/on")
                if self.hear("teleop").get("reason_code") == "rest_first":
                    time.sleep(PAUSE_S)  # after a reset, only a sender that has paused may ask again
            return condition()

        until(look, what)

    def phase(self):
        return self.state("teleop")["phase"]

    def state(self, name):
        """Return its last state; on a busy machine, after several questions."""
        return until(lambda: self.robot.ask(f"{name}/state"), f"the state of {name}")

    def servos(self, arm="arm"):
        """Return the driver's readings from the bus, by the servos' numbers."""
        return {servo["id"]: servo for servo in self.state(arm).get("servos", [])}

    def measured(self, arm):
        """Return whether all servos of an arm have answered."""
        servos = self.servos(arm).values()
        return len(servos) == 6 and all(one["voltage_v"] and one["position_rad"] is not None for one in servos)

    def joints(self, name="joints"):
        return self.state(name).get("joints", {})

    def at(self, joint, name="joints"):
        """Return the angle of a joint; look again if a servo did not answer for a moment."""
        known = lambda: self.joints(name).get(joint, {}).get("position_rad") is not None  # noqa: E731 - short
        until(known, f"where {joint} is")
        return self.joints(name)[joint]["position_rad"]

    def torques(self, arm="arm"):
        return [servo["torque"] for servo in self.servos(arm).values()]

    def torque_on(self, word="/torque/on", arm="arm"):
        self.say(word)
        until(lambda: all(self.torques(arm)), "torque")

    def play(self, word):
        """Play a pose to its end, renewing its lease like a console; again if this machine was too busy."""
        for _ in range(3):
            ended = self._play(word)
            if ended["code"] != "lapsed":
                break
            print(f"{word} lapsed and is played again")
        return ended

    def _play(self, word):
        hold = self.say(word)["hold"]
        motions = hold["key"].split("/")[1]

        def over():
            self.robot.ask(hold["key"].partition("/")[2], hold["payload"])
            return not self.state(motions)["playing"]

        until(over, f"the end of {word}")
        return self.state(motions)

    def teleop(self, phase):
        return until(lambda: (s := self.state("teleop")).get("phase") == phase and s, f"teleop is {phase}")

    def pid(self, name):
        return next(one["pid"] for one in self.robot.ask("@status")["capabilities"] if one["name"] == name)

    def fault(self, device, name, value):
        reply = self.robot.ask("world/fault", {"device": device, "name": name, "value": value})
        assert reply["accepted"], reply


@contextmanager
def arms(*edits):
    """Run the robot for the time of a `with`, from the moment when all servos were found."""
    with running("so101-sim", edits=edits) as robot:
        found = Arms(robot)
        for driver in ("arm", "leader_arm"):
            until(lambda driver=driver: found.measured(driver), f"six servos of {driver}")
        until(lambda: found.joints() and found.joints("leader_joints"), "joints")
        yield found


def setting(capability, **values):
    """Return the edit that changes settings of a capability."""
    pairs = ", ".join(f"'$.{name}', {value}" for name, value in values.items())
    return (
        f"UPDATE capability SET settings = json_set(settings, {pairs}) WHERE robot = 'so101' AND name = '{capability}'"
    )
