"""A file of what the emulated motor controller's outputs did, and when: evidence for stopping times."""

import os
from pathlib import Path

from lbr.errors import InputError


class OutputTrace:
    """Appends at once, unbuffered: `monotonic_ns left right cause` on each change, `monotonic_ns line !…` as heard.

    Left and right are wheels, forward positive. The cause is command, watchdog, emergency_stop, reset, fault (of the
    supply or temperature), unplug (the cable went; outputs as they were at that moment) or close.
    """

    def __init__(self, path: str) -> None:
        self._last: tuple[float, float] = (0.0, 0.0)
        self._file: int | None = None
        if path:
            self._file = _open(Path(path).expanduser())

    def outputs(self, now: float, outputs: tuple[float, float], cause: str, *, always: bool = False) -> None:
        """Write the outputs if they changed."""
        if outputs != self._last or always:
            self._last = outputs
            self._write(f"{now * 1e9:.0f} {outputs[0]:g} {outputs[1]:g} {cause}\n")

    def line(self, now: float, line: str) -> None:
        """Write a command line that was heard."""
        self._write(f"{now * 1e9:.0f} line {line}\n")

    def close(self, now: float) -> None:
        """Write that the controller is gone, and let go of the file."""
        if self._file is not None:
            self.outputs(now, (0.0, 0.0), "close", always=True)
            os.close(self._file)
            self._file = None

    def _write(self, text: str) -> None:
        if self._file is not None:
            os.write(self._file, text.encode())


def _open(path: Path) -> int:
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        return os.open(path, os.O_WRONLY | os.O_CREAT | os.O_APPEND | os.O_CLOEXEC, 0o644)
    except OSError as err:
        raise InputError(f"world setting `trace`: cannot write {path}: {err.strerror or err}") from err
