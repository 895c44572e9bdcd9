"""JSON Schemas of messages for foreign programs."""

from collections.abc import Mapping
from typing import Any

import msgspec

JsonObject = dict[str, Any]
"""A JSON object whose fields only its reader knows."""


def flat_schema(schema: Mapping[str, Any]) -> bytes:
    """Return a JSON Schema as bytes, with its top type in place of a reference to it, which some viewers do not
    follow."""
    reference = str(schema.get("$ref", ""))
    definitions = schema.get("$defs", {})
    own = definitions.get(reference.removeprefix("#/$defs/")) if reference else None
    found = {**own, "$defs": definitions} if own is not None else dict(schema)
    return msgspec.json.encode({"type": "object", **found})
