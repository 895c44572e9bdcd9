"""A column of a table by its field's annotation: from SQLite's value to the field's, or its fault; and back."""

import json
import math
import re
from collections.abc import Mapping
from functools import cache
from typing import Annotated, Any, Literal, NoReturn, get_args, get_origin

import msgspec
from msgspec import inspect

from lbr.messages import shapes
from lbr.messages.rows import Row, short

MAX_TEXT = 100_000
_HALF = re.compile("[\ud800-\udfff]")
_OBJECT = f"is not {shapes.OBJECT.words}"
_LIST = f"is not {shapes.LIST.words}"
_TEXTS = 'is not a JSON list of strings like ["a", "b"]'


class WrongError(Exception):
    """A value that its column may not have; the text is the broken rule."""


@cache
def columns(row: type[Row]) -> Mapping[str, "Column"]:
    """Return the columns of a table, by name."""
    return {field.name: Column(field) for field in msgspec.structs.fields(row)}


def raw(row: Row) -> dict[str, object]:
    """Return the values of a row for SQLite."""
    return {name: column.write(getattr(row, name)) for name, column in columns(type(row)).items()}


class Column:
    """Reads and writes one column. `stand_in` is a harmless value in place of an unreadable one.

    Changes of a column that is `by_lbr` are not edits.
    """

    def __init__(self, field: msgspec.structs.FieldInfo) -> None:
        self.field = field
        self._type = field.type
        self._alone = msgspec.defstruct("Alone", [("value", field.type)])  # any other type is read anew at each use
        self.info, self.extra, self.nullable = _bare(inspect.type_info(field.type))
        info = self.info
        self.is_flag = isinstance(info, inspect.BoolType)
        self.is_text = isinstance(info, inspect.StrType)
        self.is_json = not self.is_flag and not isinstance(
            info, inspect.StrType | inspect.IntType | inspect.FloatType | inspect.LiteralType
        )
        shape = self.extra.get("shape")
        self._meant = shape.words if shape is not None and self.is_text and info.pattern else ""
        self.stand_in: Any = self._stand_in(field)
        self.by_lbr = "by_lbr" in self.extra

    @property
    def holds_json(self) -> bool:
        """Return whether it holds JSON, as text."""
        return self.is_json or self.extra.get("shape") is shapes.OBJECT

    def read(self, value: Any) -> Any:
        """Return the value of a column; raise WrongError with its fault."""
        if value is None and self.nullable:
            return None
        if self.is_text and not self._meant:
            self._check_text(value)
            if self.info.min_length and not value.strip():
                raise WrongError("is empty")
        if self.is_flag and not (isinstance(value, int) and value in (0, 1)):
            raise WrongError(f"'{short(value)}' is neither 0 nor 1")
        plain = bool(value) if self.is_flag else self._json(value) if self.is_json else value
        try:
            (converted,) = msgspec.structs.astuple(msgspec.convert({"value": plain}, self._alone))
        except (msgspec.ValidationError, UnicodeError) as err:  # SQLite holds invalid text, too
            complaint = str(err).replace("$.value", "$").removesuffix(" - at `$`")
            raise WrongError(self._sentence(plain, complaint)) from None
        if isinstance(converted, float) and not math.isfinite(converted):
            raise WrongError(self._number(plain))
        if self.is_json and _texts(self.info) and any(map(text_fault, converted)):
            raise WrongError(_TEXTS)
        if self.extra.get("shape") is shapes.OBJECT and not isinstance(self._json(value), dict):
            raise WrongError(_OBJECT)
        return converted

    def write(self, value: Any) -> Any:
        """Return a value for SQLite."""
        if value is None or not (self.is_flag or self.is_json):
            return value
        return int(value) if self.is_flag else json.dumps(msgspec.to_builtins(value), ensure_ascii=False)

    @property
    def meaning(self) -> str:
        """Return the text in its annotation, or that of its type."""
        described = getattr(inspect.type_info(self._type), "extra_json_schema", None) or {}
        return next(iter(_descriptions(self._type)), described.get("description", ""))

    def choices(self) -> tuple[Any, ...]:
        """Return the values of a literal, in the order of its declaration."""
        literal = self._type
        while get_origin(literal) is Annotated:
            literal = get_args(literal)[0]
        return get_args(literal) if get_origin(literal) is Literal else tuple(self.info.values)

    def _check_text(self, value: object) -> None:
        if not isinstance(value, str):
            raise WrongError(f"is {_type(value)}, not a text")
        if fault := text_fault(value):
            raise WrongError(fault)

    def _json(self, value: Any) -> Any:
        self._check_text(value)
        try:
            return json_strictly(value)
        except RecursionError:
            raise WrongError("is not JSON: nested too deeply") from None
        except ValueError as err:
            raise WrongError(f"is not JSON: {err}") from None

    def _sentence(self, value: object, complaint: str) -> str:
        """Return the rule that a value breaks, in the words of its annotation, otherwise of msgspec."""
        info = self.info
        if self._meant:
            return f"'{short(value)}' is not {self._meant}"
        if isinstance(info, inspect.LiteralType):
            return f"'{short(value)}' is not one of {', '.join(str(one) or 'an empty text' for one in self.choices())}"
        if isinstance(info, inspect.IntType):
            bounds = f" from {info.ge} to {info.le}" if info.ge is not None and info.le is not None else ""
            return f"'{short(value)}' is not a whole number{bounds}"
        if isinstance(info, inspect.FloatType):
            return self._number(value)
        if isinstance(info, inspect.StrType):
            longer = info.max_length is not None and len(str(value)) > info.max_length
            return f"is longer than {info.max_length} characters" if longer else complaint
        return self._no_json(value, complaint)

    def _no_json(self, value: object, complaint: str) -> str:
        if isinstance(self.info, inspect.DictType):
            return self._entries(value) or complaint if isinstance(value, dict) else _OBJECT
        return _TEXTS if _texts(self.info) else _LIST if not isinstance(value, list) else complaint

    def _number(self, value: object) -> str:
        info, zero = self.info, self.extra.get("zero")
        null = " (or NULL)" if self.nullable else ""
        if info.gt is not None and zero is None:
            return f"'{short(value)}' is not above {info.gt:g} and at most {info.le:g}{null}"
        if isinstance(value, bool) or not isinstance(value, int | float) or not math.isfinite(value):
            return f"'{short(value)}' is not a finite number"
        lowest = info.ge if info.ge is not None else info.gt
        return str(zero) if value == info.gt else f"{value:g} is outside {lowest:g} to {info.le:g}"

    def _entries(self, value: Mapping[str, object]) -> str:
        """Return the fault in the entries of an object, if their annotation has a text for it."""
        _, extra, _ = _bare(self.info.value_type)
        return "; ".join(
            f"'{short(name)}': '{short(one)}' is not {extra['meant']}"
            for name, one in value.items()
            if "meant" in extra and not _fits(one, self._type, name)
        )

    def _stand_in(self, field: msgspec.structs.FieldInfo) -> object:
        if field.default is not msgspec.NODEFAULT:
            return field.default
        if field.default_factory is not msgspec.NODEFAULT:
            return field.default_factory()
        if self.nullable:
            return None
        info = self.info
        if isinstance(info, inspect.LiteralType):
            return info.values[0]
        if self.is_json:
            return {} if isinstance(info, inspect.DictType) else ()
        return "" if self.is_text else False if self.is_flag else 0


def _fits(one: object, of: object, name: str) -> bool:
    try:
        msgspec.convert({name: one}, of)
    except msgspec.ValidationError:
        return False
    return True


def _bare(info: object) -> tuple[Any, dict[str, Any], bool]:
    """Return a type without its annotations, these annotations, and whether it may be NULL."""
    if isinstance(info, inspect.Metadata):
        bare, extra, nullable = _bare(info.type)
        return bare, {**(info.extra or {}), **extra}, nullable
    if isinstance(info, inspect.UnionType):
        others = [one for one in info.types if not isinstance(one, inspect.NoneType)]
        if len(others) < len(info.types):
            bare, extra, _ = _bare(others[0]) if len(others) == 1 else (inspect.AnyType(), {}, True)
            return bare, extra, True
    return info, {}, False


def _descriptions(annotation: object) -> list[str]:
    """Return the texts in an annotation."""
    texts = [one for one in getattr(annotation, "__metadata__", ()) if isinstance(one, str)]
    return texts or [text for one in get_args(annotation) for text in _descriptions(one)]


def _texts(info: object) -> bool:
    return isinstance(info, inspect.VarTupleType) and isinstance(info.item_type, inspect.StrType)


def text_fault(text: str) -> str:
    """Return why a text is invalid, or an empty text."""
    if len(text) > MAX_TEXT:
        return f"is longer than {MAX_TEXT} characters"
    if "\0" in text:
        return "contains a NUL character"
    if not text.isascii() and _HALF.search(text):
        return "is not valid UTF-8"
    return ""


def json_strictly(text: str) -> Any:
    """Decode JSON; doubled keys, NaN, numbers beyond 64 bits and half characters raise ValueError, too."""
    value = _strict().decode(text)
    if "\\u" in text or not text.isascii():  # else it has no half character
        json.dumps(value, ensure_ascii=False).encode()
    return value


@cache
def _strict() -> json.JSONDecoder:
    return json.JSONDecoder(object_pairs_hook=_pairs, parse_constant=_constant, parse_float=_finite, parse_int=_short)


def _pairs(pairs: list[tuple[str, object]]) -> dict[str, object]:
    found = dict(pairs)
    if len(found) < len(pairs):
        raise ValueError("a key stands twice in one object")
    return found


def _constant(name: str) -> NoReturn:
    raise ValueError(f"{name} is not a number")


def _finite(text: str) -> float:
    value = float(text)
    if not math.isfinite(value):
        raise ValueError(f"{text[:30]} is too large")
    return value


def _short(text: str) -> int:
    if len(text) > 20 or not -(2**63) <= int(text) < 2**63:
        raise ValueError(f"{text[:30]} is too large")
    return int(text)


def _type(value: object) -> str:
    names = {type(None): "NULL", bytes: "a blob", int: "a number", float: "a number", str: "a text"}
    return names.get(type(value), type(value).__name__)
