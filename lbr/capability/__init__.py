"""What a driver, operation or app is: its kind, its settings and ports, and its life.

A capability of your own needs no more than this package: `Kind` to declare it, `Capability` to subclass.
"""

from lbr.capability.base import Capability
from lbr.capability.context import Asked, Call, Context, Device, Received
from lbr.capability.kind import Kind, NoSettings

__all__ = ["Asked", "Call", "Capability", "Context", "Device", "Kind", "NoSettings", "Received"]
