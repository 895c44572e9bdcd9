"""The tools of a capability's tests: a stage for one or several of them, or a context without a loop.

`Stage` runs them as they are, in one process, by a clock that is stepped; `alone` is the process of one by itself.
`FakeContext` is the context of one that the test steps itself: time is what the test says, what the capability
publishes is kept, and what it hears and is answered the test decides. `FakeCall` is a command for it.

`lbr.testing.device` plugs in a device's twin, `lbr.testing.driver` checks what every driver has to do on it,
`lbr.testing.servos` and `lbr.testing.wheels` what every driver of those has to, and `lbr.testing.robot` runs a whole
robot for the time of a test.
"""

from lbr.capability.stage import Stage, alone
from lbr.testing.context import FakeAsked, FakeCall, FakeContext, FakeEstop

__all__ = ["FakeAsked", "FakeCall", "FakeContext", "FakeEstop", "Stage", "alone"]
