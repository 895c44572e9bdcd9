"""Kind `exec`: a program in any language as a capability; its wiring is in its environment."""

from typing import Annotated, Literal

from msgspec import Meta, Struct

from lbr.capability.kind import Kind

Word = Annotated[str, Meta(min_length=1, max_length=4096, pattern="^[^\\x00]*$(?!\\n)")]
Variable = Annotated[str, Meta(pattern="^[A-Za-z_][A-Za-z0-9_]*$(?!\\n)", max_length=100)]
Port = Annotated[str, Meta(pattern="^[a-z][a-z0-9_]*$(?!\\n)", max_length=40)]
"""Without the lookahead, the pattern would accept a line break at the end, which would get into a key of the bus."""


class ProgramSettings(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Settings of a program: `argv` without a shell, and the names of its ports.

    `ready`: `start` once it runs, `token` once it declares the liveliness token `LBR_ALIVE`.
    """

    argv: Annotated[tuple[Word, ...], Meta(min_length=1, max_length=64)]
    inputs: tuple[Port, ...] = ()
    outputs: tuple[Port, ...] = ()
    commands: tuple[Port, ...] = ()
    env: dict[Variable, Word] = {}
    ready: Literal["start", "token"] = "start"


KIND = Kind(
    name="exec",
    summary="a program in any language, started without a shell, wired by its environment",
    family="program",
    entry="lbr.capability.die_with_parent:main",
    settings=ProgramSettings,
)
