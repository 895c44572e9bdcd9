"""A whole SO-101 for a test: `lbr run so101-sim`, and what a person does with it."""

import time
from contextlib import contextmanager

from lbr.testing.robot import NoAnswerError, running

SLOWLY_S = 45.0
"""Bounds waiting on a machine that has much else to do; each takes a moment on one that has not."""

PAUSE_S = 0.3
"""After that a sender counts as one that has paused."""

HELD_UP = ("late", "stale_sensor")
"""Why a line is refused on a machine that let a process wait: the line itself, or what it is judged by."""


def until(look, what, within_s=SLOWLY_S):
    end = time.monotonic() + within_s
    while not (seen := look()):
        assert time.monotonic() < end, f"not within {within_s:g} s: {what}"
        time.sleep(0.02)
    return seen


class Arms:
    """The robot as its operator sees it; `follower` and `leader` are where the joints are, by the follower's names."""

    def __init__(self, robot):
        self.robot = robot

    def say(self, line):
        """Say a line that is not refused; if this machine held it or the driver up until it was too late, say it again."""
        reply = until(lambda: (said := self.robot.say(line))["reason_code"] not in HELD_UP and said, f"{line} in time")
        assert reply["code"] == 0, reply
        return reply

    def hear(self, line):
        """Say a line that may be refused; on a busy machine an answer may come only when it is said again."""
        try:
            return self.robot.say(line)
        except NoAnswerError:
            return {"code": 1, "text": "", "hold": None}

    def follow(self, condition, what):
        """Teleoperate until something is so; a busy machine may end it, and let the follower go: then it is begun again."""

        def look():
            if self.state("teleop")["phase"] == "idle":
                self.hear("/torque/on")
                if self.hear("teleop").get("reason_code") == "rest_first":
                    time.sleep(PAUSE_S)  # what was asked for at a reset is asked for anew, by who has paused
            return condition()

        until(look, what)

    def phase(self):
        return self.state("teleop")["phase"]

    def state(self, name):
        """What it published last; on a busy machine that may have to be asked for again."""
        return until(lambda: self.robot.ask(f"{name}/state"), f"the state of {name}")

    def servos(self, arm="arm"):
        """What the driver reads back from the bus, by the servos' numbers."""
        return {servo["id"]: servo for servo in self.state(arm).get("servos", [])}

    def measured(self, arm):
        """Say whether all servos of an arm were heard."""
        servos = self.servos(arm).values()
        return len(servos) == 6 and all(one["voltage_v"] and one["position_rad"] is not None for one in servos)

    def joints(self, name="joints"):
        return self.state(name).get("joints", {})

    def at(self, joint, name="joints"):
        """Say where a joint is; a servo that did not answer for a moment is looked at again."""
        known = lambda: self.joints(name).get(joint, {}).get("position_rad") is not None  # noqa: E731 - short
        until(known, f"where {joint} is")
        return self.joints(name)[joint]["position_rad"]

    def torques(self, arm="arm"):
        return [servo["torque"] for servo in self.servos(arm).values()]

    def torque_on(self, word="/torque/on", arm="arm"):
        self.say(word)
        until(lambda: all(self.torques(arm)), "torque")

    def play(self, word):
        """Play a pose to its end, renewing its lease as a console does; again if this machine was too busy for that."""
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
    """Run the robot for the time of a `with`, from when all servos were found."""
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
