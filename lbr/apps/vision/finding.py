"""The target in a picture: the largest round thing of a colour, or the largest face. Needs OpenCV, the extra `vision`.

Positions and sizes are shares of the picture's width, whatever size it was decoded to.
"""

import contextlib
import importlib.util
from collections.abc import Callable
from pathlib import Path
from types import ModuleType

from lbr.apps.vision.settings import MODEL_HINT, VisionSettings
from lbr.errors import InputError
from lbr.messages.tracking import Seen, Target

Finder = Callable[[bytes], Seen | None]
"""Finds the target in a JPEG picture; None if it is not there, or the picture cannot be decoded."""


def check(settings: VisionSettings, target: Target) -> None:
    """Raise InputError if something that the search needs is known to be missing."""
    if importlib.util.find_spec("cv2") is None:
        raise InputError("what looks at pictures needs OpenCV: pip install 'lbr[vision]'")
    if target == "colour":
        return
    if not settings.face_model:
        raise InputError(f"a face needs a model, which does not come with lbr: {MODEL_HINT}")
    if not Path(settings.face_model).is_file():
        raise InputError(
            f"the setting `face_model` names {settings.face_model}, and there is no such file; {MODEL_HINT}"
        )


def load() -> None:
    """Load OpenCV in advance, as that is slow on a busy machine; a missing package is reported at its first use."""
    with contextlib.suppress(InputError):
        _opencv()


def finder(settings: VisionSettings, target: Target) -> Finder:
    """Return a finder of the target, within a second; raise InputError if something is missing for it."""
    check(settings, target)
    find: Finder = _opencv().finder(settings, target)
    return find


def _opencv() -> ModuleType:
    try:
        from lbr.apps.vision import opencv
    except ImportError as err:
        raise InputError(f"OpenCV cannot be used ({err}); install it again: pip install 'lbr[vision]'") from err
    return opencv
