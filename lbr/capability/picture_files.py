"""Saves pictures as files in `$LBR_HOME/pictures`."""

import os
import re
import shutil
import time
from pathlib import Path

from lbr import disk
from lbr.errors import InputError
from lbr.names import first_free

KEPT_FREE_BYTES = 100 << 20
_NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9_-]{0,79}")


def save(home: str, name: str, picture: bytes) -> Path:
    """Write a new file and return it; raise InputError with the reason."""
    if _NAME.fullmatch(name) is None:
        raise InputError("a picture's name has letters, digits, - and _, and begins with a letter or digit")
    path = Path(home) / "pictures" / f"{name}.jpg"
    try:
        path.parent.mkdir(mode=0o700, exist_ok=True)
        if shutil.disk_usage(path.parent).free < KEPT_FREE_BYTES:
            raise InputError(f"the disk is almost full; make room in {path.parent}")
        with disk.created(path) as file:
            file.write(picture)
    except FileExistsError as err:
        raise InputError(f"{path} is there already; choose another name") from err
    except OSError as err:
        raise InputError(f"{path} cannot be written ({err.strerror}); check the disk") from err
    return path


def save_now(home: str, camera: str, picture: bytes) -> Path:
    """Write a new file named after camera and time, and return it; raise InputError with the reason."""
    return save(home, free(Path(home) / "pictures" / f"{name_now(camera)}.jpg").stem, picture)


def name_now(of: str) -> str:
    """Return a name made of the picture's subject, and the time down to milliseconds."""
    now = time.time()
    return f"{of}-{time.strftime('%Y%m%d-%H%M%S', time.localtime(now))}-{int(now * 1000) % 1000:03d}"


def free(path: Path) -> Path:
    """Return the path, with a number appended to its name if the file exists already."""
    stem = first_free(path.stem, lambda name: os.path.lexists(path.with_stem(name)), "-")
    return path.with_stem(stem)
