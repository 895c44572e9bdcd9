"""The box as it is started: in a checkout that was updated without its packages it is degraded, and says what to
install."""

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
        """Records nothing, and says why."""

        def open(self) -> None:
            """Say what to install."""
            raise DeviceError(f"'{lacking}' is not installed, so nothing is recorded: run pip install -e . again")

    Box = Missing
