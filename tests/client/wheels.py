"""What the emulated wheels do."""

from contextlib import suppress

from lbr import client
from tests.support.waiting import until


def release(robot):
    """Release the emergency stop; a mover that the machine holds up is asked again."""

    def released():
        with suppress(client.RefusalError):
            robot.reset()
            return True

    until(released)


def wheels(robot):
    state = robot.ask("motors/state") or {"left": None, "right": None}
    return state["left"], state["right"]


def turning(robot):
    return wheels(robot) not in {(0.0, 0.0), (None, None)}
