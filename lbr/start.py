"""The command `lbr`: from its first moment on standard streams are open, and Ctrl-C, SIGTERM and SIGHUP count."""

import _thread
import sys
import threading

INTERRUPTED = 130
AGAIN_S = 0.02
"""Longer than what lets nothing out takes, so that the same Ctrl-C counts behind it."""


def main() -> int:
    """Run `lbr`; return its exit code."""
    sys.unraisablehook = _lost
    try:
        from lbr import surroundings  # noqa: PLC0415 - see below

        surroundings.plug_streams()
        surroundings.interrupt_by_signals()
        surroundings.note_signals()
        from lbr.cli import main as run  # noqa: PLC0415 - loading it takes a fifth of a second
    except KeyboardInterrupt:
        return INTERRUPTED
    return run()


def _lost(what: "sys.UnraisableHookArgs") -> None:
    """Have a Ctrl-C count that came where Python lets no exception out: it looks after its own locks at each import."""
    if what.exc_type is not KeyboardInterrupt:
        sys.__unraisablehook__(what)
        return
    again = threading.Timer(AGAIN_S, _thread.interrupt_main)
    again.daemon = True
    again.start()


if __name__ == "__main__":
    sys.exit(main())
