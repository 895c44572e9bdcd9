"""Console lines by chance: half of them meant well, the others not."""

import random

from tests.fuzzing.mutation import NASTY, SPLINTERS, mutated, noise

PROGRAM = "clock"
_WORDS = (
    b"s", b"S", b"stop", b"STOP", b"status", b"help", b"enable", b"disable", b"reset", b"estop", b"/estop/because/of it",
    b"f", b"b", b"/s", b"/f", b"# a comment", b"/report/health", b"/report/events", b"/report/settings", b"/report/nothing",
    b"clock", b"clock -x 'a b'", b"clock 'open", b"stop clock", b"stop it", b"/fault/nothing/silent", b"/restart/nobody",
    b"!print(1)", b"/r", b"quit", b"?", b"Shutdow", b"shutdown now",
)  # fmt: skip


def line(dice: random.Random) -> bytes:
    """Return a line without its end."""
    match dice.randrange(10):
        case 0 | 1:
            return _motion(dice, NASTY)
        case 2 | 3 | 4:
            return _motion(dice, ())
        case 5:
            return dice.choice(_WORDS)
        case 6 | 7:
            return mutated(dice, _motion(dice, NASTY), SPLINTERS + NASTY).replace(b"\n", b"")
        case 8:
            return mutated(dice, dice.choice(_WORDS), SPLINTERS + NASTY, 3).replace(b"\n", b"")
    return (noise(dice) * dice.choice((1, 1, 1, 200))).replace(b"\n", b"")


def _motion(dice: random.Random, nasty: tuple[bytes, ...]) -> bytes:
    fields = [_number(dice, 0.4), _number(dice, 360)]
    if dice.random() < 0.5:
        fields += [_number(dice, 700), dice.choice((b"forward", b"back", b"Left", b"right")), _number(dice, 60)]
    if nasty:
        fields[dice.randrange(len(fields))] = dice.choice(nasty)
    if nasty and dice.random() < 0.2:
        fields.append(dice.choice(nasty))
    return b"/r/" + b"/".join(fields)


def _number(dice: random.Random, most: float) -> bytes:
    return f"{dice.uniform(0, most):.{dice.randrange(5)}f}".encode()
