"""What the emulated wheels do."""


def wheels(robot):
    state = robot.ask("motors/state") or {"left": None, "right": None}
    return state["left"], state["right"]


def turning(robot):
    return wheels(robot) not in {(0.0, 0.0), (None, None)}
