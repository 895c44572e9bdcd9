"""A driver, operation or app: its kind, its settings and ports, and its life.

Your own capability needs only this package: `Kind` to declare it, `Capability` to subclass.
"""

from lbr.capability.base import Capability
from lbr.capability.context import Call, Context, Device, Received
from lbr.capability.kind import Command, Kind, Needs, NoSettings, OnDevice, Rights, Rows, names
from lbr.capability.word import Word
from lbr.leases.client import LeaseClient, LeaseTarget, PendingReply
from lbr.messages.rows import Row

__all__ = [
    "Call",
    "Capability",
    "Command",
    "Context",
    "Device",
    "Kind",
    "LeaseClient",
    "LeaseTarget",
    "Needs",
    "NoSettings",
    "OnDevice",
    "PendingReply",
    "Received",
    "Rights",
    "Row",
    "Rows",
    "Word",
    "names",
]
