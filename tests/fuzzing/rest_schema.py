"""Cases out of an OpenAPI document, sensible ones and others, and whether an answer is what the document says.

Knows as much of JSON Schema as the document uses; it shares nothing with what made the document.
"""

import re
from collections.abc import Mapping
from math import ceil
from typing import Any
from urllib.parse import quote, urlencode

import msgspec
from hypothesis import strategies as st

Schema = Mapping[str, Any]
NASTY = (
    "", " ", "NaN", "Infinity", "-Infinity", "-0", "1e999", "1e-9", "0x17", "0b1", "010", "5", "6", "7", "-1", "0", "255",
    "256", "254", "127", "23", "24", "20", "99", "23.5", "100.49", "null", "true", "[]", "{}", "pos", "\x00", "é", "…", "'",
    '"', "<b>", "../..", "%", "9" * 40,
)  # fmt: skip
OTHER_BODIES = (
    b"",
    b"{",
    b"null",
    b"[]",
    b"7",
    b'"x"',
    b"{}",
    b"\xff\xfe",
    b"[" * 2000,
    b'{"motors": null}',
    b"x" * 70_000,
)
OTHER_TYPES = (
    "text/plain",
    "application/x-www-form-urlencoded",
    "",
    "application/json; charset=utf-8",
    "multipart/form-data",
)


class Case(msgspec.Struct, frozen=True):
    """A request; `route` is its path in the document."""

    method: str
    route: str
    url: str
    body: bytes
    media: str

    def __str__(self) -> str:
        return f"{self.method} {self.url} {self.media} {self.body[:300]!r}"


def cases(document: Schema) -> dict[tuple[str, str], st.SearchStrategy[Case]]:
    """Return requests to each of the document's operations, by path and method."""
    return {
        (path, method.upper()): _case(document, method.upper(), path, operation)
        for path, methods in document["paths"].items()
        for method, operation in methods.items()
    }


def misfit(document: Schema, case: Case, status: int, media: str, body: bytes) -> str:
    """Return in what an answer is not what the document says of it; empty if it is."""
    responses = document["paths"][case.route][case.method.lower()]["responses"]
    found = responses.get(str(status))
    if found is None:
        return f"status {status} is not in the document"
    kinds = found.get("content", {})
    if not kinds:
        return "there is content where none is said" if body or media else ""
    kind = media.partition(";")[0]
    if kind not in kinds:
        return f"{kind} is not one of {sorted(kinds)}"
    if kind != "application/json":
        return ""
    try:
        return wrong(document, kinds[kind]["schema"], msgspec.json.decode(body), "$")
    except msgspec.DecodeError as err:
        return f"no JSON: {err}"


def wrong(document: Schema, schema: Schema, value: Any, at: str) -> str:
    """Return why a value is not what a schema says; empty if it is."""
    if "$ref" in schema:
        return wrong(document, _deref(document, schema), value, at)
    if "anyOf" in schema:
        whys = [wrong(document, each, value, at) for each in schema["anyOf"]]
        return "" if "" in whys else "; ".join(whys)
    if "const" in schema or "enum" in schema:
        allowed = schema.get("enum", [schema.get("const")])
        return "" if value in allowed else f"{at}: {value!r} is not one of {allowed}"
    kind = schema.get("type")
    if kind is not None and not _is(kind, value):
        return f"{at}: {value!r} is no {kind}"
    if isinstance(value, dict):
        return _wrong_object(document, schema, value, at)
    if isinstance(value, list):
        return _wrong_items(document, schema, value, at)
    return _wrong_scalar(schema, value, at)


def _wrong_items(document: Schema, schema: Schema, value: list[Any], at: str) -> str:
    first, others = schema.get("prefixItems", []), schema.get("items", {})
    if others is False and len(value) > len(first):
        return f"{at}: {len(value)} where the document has {len(first)}"
    parts = [first[n] if n < len(first) else others for n in range(len(value))]
    whys = (wrong(document, part, one, f"{at}[{n}]") for n, (part, one) in enumerate(zip(parts, value, strict=True)))
    return next((why for why in whys if why), "")


def _wrong_object(document: Schema, schema: Schema, value: dict[str, Any], at: str) -> str:
    known = schema.get("properties", {})
    missing = set(schema.get("required", ())) - value.keys()
    if missing:
        return f"{at}: {', '.join(sorted(missing))} missing"
    others = schema.get("additionalProperties", True)
    if "properties" in schema and (unknown := value.keys() - known.keys()) and not isinstance(others, dict):
        return f"{at}: {', '.join(sorted(unknown))} not in the document"
    for name, one in value.items():
        part = known.get(name, others if isinstance(others, dict) else {})
        if why := wrong(document, part, one, f"{at}.{name}"):
            return why
    return ""


def _wrong_scalar(schema: Schema, value: Any, at: str) -> str:
    if isinstance(value, str) and "pattern" in schema and not re.search(schema["pattern"], value):
        return f"{at}: {value!r} does not match {schema['pattern']}"
    if isinstance(value, bool) or not isinstance(value, int | float):
        return ""
    within = schema.get("minimum", value) <= value <= schema.get("maximum", value)
    return "" if within else f"{at}: {value} is out of bounds"


def _is(kind: str, value: Any) -> bool:
    if isinstance(value, bool):
        return kind == "boolean"
    kinds = {"object": dict, "array": list, "string": str, "null": type(None), "integer": int, "number": (int, float)}
    return isinstance(value, kinds[kind]) if kind in kinds else False


def _deref(document: Schema, schema: Schema) -> Schema:
    found: Any = document
    for part in schema["$ref"].removeprefix("#/").split("/"):
        found = found[part]
    return found


@st.composite
def _case(draw: st.DrawFn, document: Schema, method: str, path: str, operation: Schema) -> Case:
    keys, query = {}, []
    odd = draw(st.integers(0, 2)) == 0
    for parameter in operation.get("parameters", ()):
        value = _typed(document, parameter["schema"])
        if odd:
            value = value | st.sampled_from(NASTY) | st.integers(-2, 30).map(str)
        if parameter["in"] == "path":
            keys[parameter["name"]] = draw(
                st.sampled_from(KNOWN) | value.filter(lambda text: text not in {"", ".", ".."})
                if odd
                else st.sampled_from(KNOWN)
            )
        elif draw(st.integers(0, 99)) < (60 if parameter["name"] == "id" else 35):
            query += [
                (parameter["name"], one)
                for one in draw(st.lists(value, min_size=1, max_size=draw(_RARELY_TWO) if odd else 1))
            ]
    url = re.sub(r"\{([a-z_]+)\}", lambda found: quote(keys[found[1]], safe=""), path)
    url += f"?{urlencode(query)}" if query else ""
    body, media = b"", ""
    if "requestBody" in operation:
        schema = operation["requestBody"]["content"]["application/json"]["schema"]
        sensible = _value(document, schema, odd=odd).map(msgspec.json.encode)
        body = draw(sensible | sensible | st.sampled_from(OTHER_BODIES) if odd else sensible)
        media = draw(st.sampled_from(("application/json",) * 4 + OTHER_TYPES) if odd else st.just("application/json"))
    return Case(method, path, url, body, media)


_RARELY_TWO = st.sampled_from([1] * 9 + [2])
KNOWN = ("1", "3", "4", "7", "99", "23", "24", "100", "basic_motion", "Pc_Control", "stop", "reset")


def _typed(document: Schema, schema: Schema) -> st.SearchStrategy[str]:
    """Return texts for a parameter that the document says is something else."""
    return (
        _value(document, schema)
        .filter(lambda value: value is not None)
        .map(lambda value: value if isinstance(value, str) else msgspec.json.encode(value).decode())
    )


def _value(document: Schema, schema: Schema, *, odd: bool = False, top: bool = True) -> st.SearchStrategy[Any]:
    """Return values that a schema allows, mostly."""
    if "$ref" in schema:
        return _value(document, _deref(document, schema), odd=odd, top=top)
    if "anyOf" in schema:
        return st.one_of([_value(document, each, odd=odd, top=top) for each in schema["anyOf"]])
    if "enum" in schema or "const" in schema:
        return st.sampled_from(schema.get("enum", [schema.get("const")]))
    found = _BY_KIND.get(schema.get("type", ""), _anything)(document, schema, odd)
    return found | found | found | _ODD if odd and not top else found


def _number(document: Schema, schema: Schema, odd: bool) -> st.SearchStrategy[Any]:
    del document, odd
    low, high = schema.get("minimum", schema.get("exclusiveMinimum", -10.05) + 0.05), schema.get("maximum", 300)
    if high - low <= 20.0 and low < 0.0:
        return st.sampled_from([-0.2, 0.0, 0.1]) | st.floats(low, high)
    if schema["type"] == "integer":
        return st.integers(ceil(low), int(high)) | st.sampled_from(
            [one for one in (23, 24, 20, 22) if low <= one <= high] or [ceil(low)]
        )
    return st.floats(low, high, allow_nan=False) | st.integers(ceil(low), int(high))


def _string(document: Schema, schema: Schema, odd: bool) -> st.SearchStrategy[Any]:
    del document, odd
    if "pattern" in schema:
        return st.from_regex(schema["pattern"], fullmatch=True).filter(lambda text: len(text) < 60)
    return st.text(max_size=min(20, schema.get("maxLength", 20)), min_size=schema.get("minLength", 0))


def _array(document: Schema, schema: Schema, odd: bool) -> st.SearchStrategy[Any]:
    return st.lists(
        _value(document, schema.get("items", {}), odd=odd, top=False), min_size=schema.get("minItems", 0), max_size=6
    )


def _object(document: Schema, schema: Schema, odd: bool) -> st.SearchStrategy[Any]:
    known = {name: _value(document, part, odd=odd, top=False) for name, part in schema.get("properties", {}).items()}
    if not known:
        values = schema.get("additionalProperties")
        part = _value(document, values, odd=odd, top=False) if isinstance(values, dict) else st.integers()
        return st.dictionaries(st.sampled_from(["23", "24", "neck_yaw", "head_pitch", "x"]), part, max_size=3)
    required = set(schema.get("required", ()))
    return st.fixed_dictionaries(
        {name: known[name] for name in known if name in required},
        optional={name: known[name] for name in known if name not in required},
    )


def _anything(document: Schema, schema: Schema, odd: bool) -> st.SearchStrategy[Any]:
    del document, schema, odd
    return _ODD


_ODD = st.sampled_from([None, True, -1, 0, 1.5, 1e300, "", "x", [], {}, [[]]])
_BY_KIND = {
    "integer": _number,
    "number": _number,
    "string": _string,
    "array": _array,
    "object": _object,
    "boolean": lambda *_: st.booleans(),
    "null": lambda *_: st.none(),
}
