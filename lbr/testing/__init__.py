"""The tools of a capability's tests: a stage for one or several of them, or a context without a loop.

`Stage` runs real capabilities in one process, on a stepped clock; `alone` is the process of one by itself.
`FakeContext` is the context of one capability that the test steps: the test sets time, messages and answers, and reads
the publications. `FakeCall` is a command for it.

`lbr.testing.device` plugs in a device's twin, and `lbr.testing.driver` checks every driver's duties on it.
`lbr.testing.servos` and `lbr.testing.wheels` check those of their drivers. `lbr.testing.robot` runs a whole robot for
the time of a test.
"""

from lbr.capability.stage import Stage, alone
from lbr.testing.context import FakeAsked, FakeCall, FakeContext, FakeEstop

__all__ = ["FakeAsked", "FakeCall", "FakeContext", "FakeEstop", "Stage", "alone"]
