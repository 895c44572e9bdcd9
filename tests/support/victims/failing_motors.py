"""The motor driver, which goes wrong when told to."""

import sys
from dataclasses import replace
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))

from failures import Fail, fail  # type: ignore[import-not-found]

from lbr.capability.context import Call
from lbr.drivers import roboteq
from lbr.drivers.roboteq.capability import Roboteq
from lbr.messages.leases import CommandReply


class FailingMotors(Roboteq):
    def command(self, call: Call) -> None:
        if not isinstance(call.message, Fail):
            super().command(call)
            return
        call.reply(CommandReply(accepted=True))
        fail(call.message.how, f"{self.ctx.home}/run/{self.ctx.robot}.sock")


KIND = replace(
    roboteq.KIND,
    name="failing_motors",
    entry=FailingMotors,
    commands={**roboteq.KIND.commands, "fail": Fail},
    replies={**roboteq.KIND.replies, "fail": CommandReply},
)
