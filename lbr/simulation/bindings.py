"""The types of MuJoCo, whose bindings carry none; importing this does not import MuJoCo."""

from typing import Any, TypeAlias

MjModel: TypeAlias = Any
MjData: TypeAlias = Any
MjSpec: TypeAlias = Any
MjsBody: TypeAlias = Any
