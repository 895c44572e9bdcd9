"""A user's own capability file: it is tried in a separate process first, because importing it runs its code.

`python -m lbr.capability.user_kinds` is that process. A robot's own programs import only files that were imported there
in time, with a complete kind.
"""

import ast
import contextlib
import faulthandler
import importlib.util
import os
import re
import select
import signal
import subprocess
import sys
import traceback
from functools import partial
from importlib.machinery import SourceFileLoader
from importlib.util import decode_source
from pathlib import Path
from types import CodeType

from lbr import plugins
from lbr.capability.faults import faults
from lbr.capability.kind import Kind, KindError
from lbr.errors import told

LIMIT_S = 5.0
"""Importing lbr with numpy takes a Raspberry Pi 4 about two; longer work belongs into `open`, or behind `entry`."""
START_S = 20.0
"""The time for the trial's own interpreter before and after that, on a busy machine."""
GOOD = b"good"


def find(name: str, path: Path) -> Kind:
    """Return the kind of a file that passed its trial, after a while; raise KindError with reason, file and line."""
    if fault := trial(name, path):
        raise KindError(fault)
    kind, err = plugins.tried_aside(partial(load, name, path))
    if kind is None:
        assert err is not None
        raise err if isinstance(err, KindError) else _unloaded(path, err)
    return kind


def trial(name: str, path: Path) -> str:
    """Import a file in a process that may hang, print and exit; return why the file is unusable, or an empty text."""
    report = os.memfd_create(f"trial of {name}")
    try:
        popen = subprocess.Popen(
            [sys.executable, "-P", "-m", "lbr.capability.user_kinds", name, str(path), str(report), str(LIMIT_S)],
            stdin=subprocess.DEVNULL,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
            pass_fds=(report,),
            start_new_session=True,
        )
        code = _end_of(popen)
        text = os.pread(report, 1 << 16, 0)
    except OSError as err:
        return f"{path} cannot be tried: {err}"
    finally:
        os.close(report)
    if text == GOOD:
        return ""
    kind, _, rest = text.decode(errors="replace").partition("\n")
    if kind == "fault":
        return rest
    if text or code is None:
        lines = re.findall(rf'File "{re.escape(str(path))}", line (\d+)', rest)
        return _too_slow(path, int(lines[0]) if lines else None)
    how = f"with exit code {code}" if code >= 0 else f"by signal {-code}"
    return f"{path} ends the process that imports it, {how}: let it declare KIND and do nothing else"


def load(name: str, path: Path, source: str = "") -> Kind:
    """Import a file, or its accepted text, by running its code, and return its kind; KindError names file and line."""
    module_name = _module_name(name)
    loader = _FromSource(module_name, str(path))
    loader.text = source
    spec = importlib.util.spec_from_file_location(module_name, path, loader=loader)
    assert spec is not None
    module = importlib.util.module_from_spec(spec)
    before = sys.modules.get(module_name)
    sys.modules[module_name] = module
    try:
        try:
            loader.exec_module(module)
        except KeyboardInterrupt:  # a person's Ctrl-C is not the file's fault
            raise
        except BaseException as err:  # a file may raise anything; the trial reports it
            raise _unloaded(path, err) from err
        return _whole(name, path, module)
    except (KindError, KeyboardInterrupt):
        if before is not None:  # running code still finds its types there
            sys.modules[module_name] = before
        else:
            sys.modules.pop(module_name, None)
        raise


def source(name: str) -> str:
    """Return the text of the file last imported as the kind of that name; empty without one."""
    loader = getattr(sys.modules.get(_module_name(name)), "__loader__", None)
    return loader.text if isinstance(loader, _FromSource) else ""


def _module_name(name: str) -> str:
    return f"lbr_user_capabilities.{name}"


class _FromSource(SourceFileLoader):
    """Reads and compiles the file itself: a compiled copy could be older, or another user's. `text` is the source."""

    text = ""

    def get_code(self, fullname: str) -> CodeType | None:  # noqa: ARG002 - as the import system calls it
        self.text = self.text or decode_source(self.get_data(self.path))
        return self.source_to_code(self.text, self.path)


def _whole(name: str, path: Path, module: object) -> Kind:
    """Return the kind that a module declares, if it is faultless."""
    kind = getattr(module, "KIND", None)
    place = _place(path, _line_of_kind(path))
    if not isinstance(kind, Kind):
        raise KindError(f"{place} declares no KIND = Kind(…): kind '{name}' is what the file gives that name")
    if kind.name != name:
        text = f"kind '{name}' calls itself '{kind.name}': the name of the file and KIND.name agree"
        raise KindError(f"{place}: {text}")
    if found := faults(kind):
        raise KindError(f"{place}: {'; '.join(found)}")
    return kind


def _unloaded(path: Path, err: BaseException) -> KindError:
    return KindError(f"{_place(path, _line(err, path))} does not load: {told(err)}")


def _line_of_kind(path: Path) -> int | None:
    with contextlib.suppress(OSError, ValueError, SyntaxError):
        for node in ast.parse(path.read_bytes()).body:
            targets = node.targets if isinstance(node, ast.Assign) else [getattr(node, "target", None)]
            if any(isinstance(target, ast.Name) and target.id == "KIND" for target in targets):
                return node.lineno
    return None


def _line(err: BaseException, path: Path) -> int | None:
    """Return the line of the file in which the error occurred."""
    if isinstance(err, SyntaxError) and err.filename == str(path):
        return err.lineno
    frames = traceback.extract_tb(err.__traceback__)
    return next((frame.lineno for frame in reversed(frames) if frame.filename == str(path)), None)


def _place(path: Path, line: int | None) -> str:
    return f"{path}, line {line}" if line else str(path)


def _too_slow(path: Path, line: int | None) -> str:
    do = 'import what is slow in `open`, or name the class as entry="module:Class"'
    return f"{_place(path, line)} is not imported within {LIMIT_S:g} s: {do}"


def _end_of(popen: "subprocess.Popen[bytes]") -> int | None:
    """Return the exit code of a trial, and end all that it started; None if the trial had to be ended itself."""
    ended = select.poll()
    pid_fd = os.pidfd_open(popen.pid)
    try:
        ended.register(pid_fd, select.POLLIN)
        in_time = bool(ended.poll((LIMIT_S + START_S) * 1000))
    finally:
        os.close(pid_fd)
        with contextlib.suppress(ProcessLookupError):
            os.killpg(popen.pid, signal.SIGKILL)
        code = popen.wait()
    return code if in_time else None


def main() -> None:
    """Try one file, and write the result to the inherited descriptor."""
    name, path, report, limit_s = sys.argv[1], Path(sys.argv[2]), int(sys.argv[3]), float(sys.argv[4])
    os.set_inheritable(report, False)
    faulthandler.dump_traceback_later(limit_s, exit=True, file=report)
    try:
        load(name, path)
        text = GOOD
    except KindError as err:
        text = f"fault\n{err}".encode(errors="replace")
    except KeyboardInterrupt as err:  # not a terminal's, as this process has none: the file raised it
        text = f"fault\n{_unloaded(path, err)}".encode(errors="replace")
    faulthandler.cancel_dump_traceback_later()
    os.write(report, text)
    os._exit(0)  # whatever it has started meanwhile


if __name__ == "__main__":
    main()
