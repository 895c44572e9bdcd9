"""What packages of others may build on: every public name of these modules, with its signature or its fields.

`python -m tests.api.surface` writes it to `surface.txt`. What is new is added by that; what is gone or changed breaks
packages of others, and is a decision that the changelog tells.
"""

import inspect
import pkgutil
from collections.abc import Iterator
from importlib import import_module
from pathlib import Path
from types import ModuleType
from typing import Any

from msgspec import NODEFAULT, Struct, structs

from lbr import plugins

MODULES = (
    "lbr.capability",
    "lbr.client",
    "lbr.client.aio",
    "lbr.component",
    "lbr.messages",
    "lbr.drivers.servos",
    "lbr.drivers.wheels",
    "lbr.apps.web.ports",
)
PINNED = Path(__file__).with_name("surface.txt")


def surface() -> list[str]:
    """Return a line for each name, in order."""
    return sorted(
        {line for name in (*MODULES, *plugins.messages()) for module in _modules(name) for line in _of_module(module)}
        | set(_names())
    )


def _modules(name: str) -> Iterator[ModuleType]:
    """Go through a package; where it says in `__all__` what it exports, its modules are its own affair."""
    module = import_module(name)
    yield module
    if not hasattr(module, "__all__"):
        for found in pkgutil.iter_modules(getattr(module, "__path__", ())):
            yield import_module(f"{name}.{found.name}")


def _of_module(module: ModuleType) -> Iterator[str]:
    exported = getattr(module, "__all__", None)
    for name, value in vars(module).items():
        here = name in exported if exported is not None else getattr(value, "__module__", None) == module.__name__
        if not here or name.startswith("_") or not (inspect.isclass(value) or inspect.isfunction(value)):
            continue
        yield from _of_value(f"{module.__name__}.{name}", value)


def _of_value(path: str, value: Any) -> Iterator[str]:
    if inspect.isfunction(value):
        yield f"{path}{_signature(value)}"
    elif issubclass(value, Struct):
        yield f"{path}: {', '.join(base.__name__ for base in value.__bases__)}"
        yield from (f"{path}.{field.name}: {_field(field)}" for field in structs.fields(value))
    else:
        yield f"{path}: {', '.join(base.__name__ for base in value.__bases__)}"
        for name, member in vars(value).items():
            if not name.startswith("_"):
                inner = member.fget if isinstance(member, property) else getattr(member, "__func__", member)
                yield f"{path}.{name}{_signature(inner) if inspect.isfunction(inner) else ''}"


def _field(field: structs.FieldInfo) -> str:
    if field.default is not NODEFAULT:
        return f"{_type(field.type)} = {field.default!r}"
    return _type(field.type) + (" = …" if field.default_factory is not NODEFAULT else "")


def _signature(function: Any) -> str:
    return _plain(str(inspect.signature(function)))


def _type(hint: Any) -> str:
    return _plain(inspect.formatannotation(hint))


def _plain(text: str) -> str:
    return text.replace("typing.", "").replace("collections.abc.", "").replace("msgspec._core.", "")


def _names() -> Iterator[str]:
    return (f"component {field}: {one.name}" for field in plugins.FIELDS for one in plugins.own(field))


if __name__ == "__main__":
    PINNED.write_text("".join(f"{line}\n" for line in surface()), encoding="utf-8")
