"""Records the stages of a command in a robot's own processes, by wrapping their functions; on their PYTHONPATH."""

import os
import sys
from typing import Any

FOLDER = os.environ.get("BENCHMARK_STAGES", "")


def _around(owner: Any, name: str, before: Any, after: Any = None) -> None:
    inner = getattr(owner, name)

    def around(*given: Any, **named: Any) -> Any:
        if before is not None:
            before(*given)
        found = inner(*given, **named)
        if after is not None:
            after(*given)
        return found

    setattr(owner, name, around)


def _put_in() -> None:
    from benchmarks.instruments.stages import NAMES, Stamps  # of the folder named last on the path
    from lbr.bus import wire
    from lbr.capability.runtime import ProcessContext
    from lbr.drivers.serial_line import SerialLine
    from lbr.drivers.wheels.capability import Wheels
    from lbr.operations.drive.capability import Drive

    reached = Stamps(FOLDER).reached
    number = {name: place for place, name in enumerate(NAMES)}

    def stamp(name: str) -> Any:
        return lambda *_given: reached(number[name])

    def put(name: str) -> Any:
        def noted(publisher: Any, message: Any) -> None:
            if publisher.key.endswith("/setpoint"):
                reached(number[name], round(abs(message.left) * 1000))

        return noted

    def written(_line: Any, data: bytes) -> None:
        if data.startswith(b"!M"):
            reached(number["written"], abs(int(data.split()[1])))

    def heard(_subscription: Any, sample: Any) -> None:
        if str(sample.key_expr).endswith("/setpoint"):
            reached(number["heard"])

    _around(wire.QueryServer, "queue", stamp("arrived"))
    _around(wire.Subscription, "_store", heard)
    _around(wire.Request, "forward_reply", None, stamp("replied"))
    _around(wire.Publisher, "put", put("sent"), put("given"))
    _around(ProcessContext, "_call", stamp("woken"))
    _around(Drive, "command", stamp("decoded"))
    _around(Drive, "decide", None, stamp("decided"))
    _around(Wheels, "step", stamp("stepped"))
    _around(Wheels, "_act", stamp("gated"))
    _around(SerialLine, "write", None, written)


if FOLDER and any(word.startswith("lbr.capability.") for word in sys.orig_argv):
    _put_in()
