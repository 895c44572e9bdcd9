"""Draws pictures of the world beside its loop, and answers the sender once they are on the disk."""

import os
from collections.abc import Callable
from concurrent.futures import Future, ThreadPoolExecutor
from pathlib import Path
from typing import TYPE_CHECKING

from msgspec import Struct

from lbr.capability.context import Call, Context
from lbr.capability.picture_files import free, name_now
from lbr.errors import InputError
from lbr.messages.rows import short
from lbr.simulation.requests import PictureReply

if TYPE_CHECKING:
    from PIL.Image import Image

_WAITING = 8


class Painter:
    """One picture at a time, in a thread of its own; replies are sent from `finish`."""

    def __init__(self, ctx: Context[Struct]) -> None:
        self._ctx = ctx
        self._worker = ThreadPoolExecutor(max_workers=1, thread_name_prefix="painter", initializer=_rank_as_usual)
        self._calls: list[tuple[Call, Path, Future[Path]]] = []

    def ask(self, call: Call, wanted: str, draw: Callable[[], "Image"]) -> None:
        """Draw a picture and save it as a new file; an existing one stays as it is.

        Without a path, it goes to the home's pictures, under a free name.
        """
        try:
            path = Path(os.path.expanduser(wanted)) if wanted else _own_path(self._ctx)  # noqa: PTH111 - never fails
        except InputError as err:
            call.refuse(str(err), err.code)
            return
        if path.suffix != ".png" or not path.is_absolute() or "\0" in wanted:
            call.refuse(f"a picture's path is absolute and ends in .png; '{short(str(path))}' is not", "bad_value")
        elif len(self._calls) >= _WAITING:
            call.refuse(f"{_WAITING} pictures are waiting already", "busy")
        else:
            self._calls.append((call, path, self._worker.submit(_save, path, draw, bool(wanted))))

    def finish(self) -> None:
        """Answer for every finished picture."""
        done = [entry for entry in self._calls if entry[2].done()]
        self._calls = [entry for entry in self._calls if entry not in done]
        for call, path, work in done:
            error = work.exception()
            if error is None:
                call.reply(PictureReply(accepted=True, path=str(work.result())))
            elif isinstance(error, OSError):
                call.refuse(f"cannot write {path}: {error.strerror or error}", "failed")
            else:
                raise error

    def close(self) -> None:
        """Finish the present picture; waiting ones are refused."""
        self._worker.shutdown(wait=False, cancel_futures=True)
        for call, _, _ in self._calls:
            call.refuse("the world is closing", "shutting_down")
        self._calls.clear()


def _rank_as_usual() -> None:
    """Lower the rank of this thread: the world ranks with the movers, but a picture has time."""
    if os.getpriority(os.PRIO_PROCESS, 0) < 0:
        os.setpriority(os.PRIO_PROCESS, 0, 0)


def _own_path(ctx: Context[Struct]) -> Path:
    folder = Path(ctx.home) / "pictures"
    try:
        folder.mkdir(mode=0o700, exist_ok=True)
    except OSError as err:
        raise InputError(f"{folder} cannot be made ({err.strerror}): name a file for the picture", "failed") from None
    return folder / f"{name_now(ctx.robot)}.png"


def _save(path: Path, draw: Callable[[], "Image"], named: bool) -> Path:
    picture = draw()
    if not named:
        path = free(path)
    with path.open("xb") as file:
        picture.save(file, format="PNG", compress_level=1)
    return path
