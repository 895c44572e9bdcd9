"""The box as it is started: degraded in a checkout that was updated without its packages."""

from lbr.apps.recorder.box.kind import BoxSettings
from lbr.capability.base import Capability
from lbr.errors import DeviceError

Box: type[Capability[BoxSettings]]
try:
    from lbr.apps.recorder.box import capability

    Box = capability.Box
except ImportError as err:
    lacking = err.name or "a package"

    class Missing(Capability[BoxSettings]):
        """A box without its packages, which records nothing."""

        def open(self) -> None:
            """Raise DeviceError with the command that installs them."""
            raise DeviceError(f"'{lacking}' is not installed, so nothing is recorded: run pip install -e . again")

    Box = Missing
