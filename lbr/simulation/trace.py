"""Trace files of the input and output of emulated devices, with times: evidence of bytes, and of stopping times."""

import os
from pathlib import Path

from lbr.errors import InputError
from lbr.messages.rows import short


class TraceFile:
    """Appends at once, unbuffered: lines of `monotonic_ns` and an event; nothing without a path.

    `setting` names the path's setting, for the error if it is not writable.
    """

    def __init__(self, path: str, setting: str) -> None:
        self._file = _open(path, setting) if path else None

    @property
    def wanted(self) -> bool:
        """Return whether it writes anything."""
        return self._file is not None

    def write(self, now: float, text: str) -> None:
        """Add a line."""
        if self._file is not None:
            os.write(self._file, f"{now * 1e9:.0f} {text}\n".encode())

    def close(self) -> None:
        """Close the file."""
        if self._file is not None:
            os.close(self._file)
            self._file = None


class OutputTrace:
    """Appends at once, unbuffered: `monotonic_ns left right cause` on each change, `monotonic_ns line !…` for each
    line.

    Left and right are wheels, forward positive. The cause is command, watchdog, emergency_stop, reset, fault, unplug or
    close. `fault` is of the supply or temperature; `unplug` has the outputs at the moment when the cable went.
    """

    def __init__(self, path: str) -> None:
        self._last: tuple[float, float] = (0.0, 0.0)
        self._file = TraceFile(path, "world setting `trace`")

    def outputs(self, now: float, outputs: tuple[float, float], cause: str, *, always: bool = False) -> None:
        """Write the outputs if they changed."""
        if outputs != self._last or always:
            self._last = outputs
            self._file.write(now, f"{outputs[0]:g} {outputs[1]:g} {cause}")

    def line(self, now: float, line: str) -> None:
        """Write a received command line."""
        self._file.write(now, f"line {line}")

    def close(self, now: float) -> None:
        """Write that the controller is gone, and close the file."""
        if self._file.wanted:
            self.outputs(now, (0.0, 0.0), "close", always=True)
            self._file.close()


def _open(path: str, setting: str) -> int:
    try:
        file = Path(path).expanduser()
        file.parent.mkdir(parents=True, exist_ok=True)
        return os.open(file, os.O_WRONLY | os.O_CREAT | os.O_APPEND | os.O_CLOEXEC, 0o644)
    except (OSError, RuntimeError, ValueError) as err:  # ~ of nobody, a NUL
        why = err.strerror if isinstance(err, OSError) else err
        raise InputError(f"{setting}: cannot write {short(path)}: {why}") from err
