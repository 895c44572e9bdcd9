"""What the emulated wheels do, and how a motion of theirs ends or is refused whose robot or client the machine holds up."""

NOT_YET = {"not_armed", "no_setpoint", "held", "stale_sensor", "late", "unreachable"}
HELD_UP = NOT_YET | {"lapsed", "dead_lease", "holder_gone"}


def wheels(robot):
    state = robot.ask("motors/state") or {"left": None, "right": None}
    return state["left"], state["right"]


def turning(robot):
    return wheels(robot) not in {(0.0, 0.0), (None, None)}
