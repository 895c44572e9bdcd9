"""An app that has been taken over: it gives away what it was started with, and does nothing else."""

import gc
from pathlib import Path

import msgspec
from msgspec import Struct

from lbr.capability.base import Capability
from lbr.capability.config import ProcessConfig
from lbr.capability.context import Context
from lbr.capability.kind import Kind, NoSettings
from lbr.messages.drive import DriveState
from lbr.messages.system import Event


class Poke(Struct, frozen=True, kw_only=True):
    """Nothing happens."""

    text: str = ""


class Spy(Capability[NoSettings]):
    def __init__(self, ctx: Context[NoSettings]) -> None:
        super().__init__(ctx)
        config = next(one for one in gc.get_objects() if isinstance(one, ProcessConfig))
        new = Path(ctx.home) / f"{ctx.name}.new"
        new.write_bytes(msgspec.json.encode(config))
        new.rename(Path(ctx.home) / f"{ctx.name}.json")


KIND = Kind(
    name="spy",
    summary="gives away its credentials",
    family="app",
    entry=Spy,
    inputs={"seen": DriveState},
    outputs={"found": Event},
    commands={"poke": Poke},
)
