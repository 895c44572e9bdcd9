"""The command `lbr`: from its first moment on standard streams are open, and Ctrl-C, SIGTERM and SIGHUP work."""

import _thread
import sys
import threading

INTERRUPTED = 130
AGAIN_S = 0.02
"""Longer than the section that drops exceptions, so that the same Ctrl-C counts after it."""


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
    """Repeat a Ctrl-C that came where Python drops exceptions: it manages its own locks at each import."""
    if what.exc_type is not KeyboardInterrupt:
        sys.__unraisablehook__(what)
        return
    again = threading.Timer(AGAIN_S, _thread.interrupt_main)
    again.daemon = True
    again.start()


if __name__ == "__main__":
    sys.exit(main())
