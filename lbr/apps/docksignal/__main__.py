"""The program: `python -m lbr.apps.docksignal left right`."""

import sys

from lbr.apps import program
from lbr.bus import codec, keys, wire
from lbr.errors import BusError, InputError, MalformedError
from lbr.messages.dock import DockHeard

BEAMS = ("left", "right", "power")


def signal(words: list[str]) -> DockHeard:
    """Return the beams of these words; raise InputError with the allowed words."""
    beams = [word.removesuffix("_signal") for word in words]
    wrong = next((word for word, beam in zip(words, beams, strict=True) if beam not in BEAMS), None)
    if wrong is not None:
        raise InputError(f"'{wrong[:40]}' is not a beam of a dock; say left, right or power, or several of them")
    if not beams:
        raise InputError("which beam? say left, right or power, or several of them")
    return DockHeard(**dict.fromkeys(beams, True))


def main() -> int:
    """Report the beams to the robot's capability `dock`."""
    message = signal(sys.argv[1:])
    with program.connected("docksignal") as robot:
        answers = wire.ask(robot.bus, keys.port(robot.name, "dock", "heard"), message, source=robot.source)
    if not answers:
        raise BusError("no capability listens: 'dock' does not run; 'lbr status' shows the reason")
    try:
        answer = codec.decode(answers[0].payload)
    except MalformedError as err:
        raise BusError(f"the answer makes no sense: {err}") from err
    if not answer.get("accepted"):
        raise BusError(str(answer.get("reason", "refused")))
    print("the dock capability received:", " ".join(name for name in BEAMS if getattr(message, name)))
    return 0


if __name__ == "__main__":
    sys.exit(program.run(main))
