"""The OpenAPI paths of a robot's streams and commands, from the schemas in the robot's description. Pure."""

from collections.abc import Iterator, Mapping
from typing import Any

import msgspec

from lbr.apps.web import openapi
from lbr.apps.web.api.catalog import Catalog
from lbr.apps.web.face import JSON, Message
from lbr.messages.description import CapabilityDescription, CommandDescription, Schema
from lbr.messages.leases import CommandReply

_DEFS, _COMPONENTS = "#/$defs/", "#/components/schemas/"
UNKNOWN = 404
REFUSED: Schema = {
    "type": "object",
    "properties": {"message": {"type": "string"}, "code": {"type": "string"}},
    "required": ["message"],
    "additionalProperties": {},
}
"""A refusal of a command, with the other fields of the capability's reply."""


def with_robot(document: Schema, catalog: Catalog) -> Schema:
    """Add a path for each stream and command of a robot to a server's document."""
    components = Components(document["components"]["schemas"])
    reply = components.add(msgspec.json.schema(CommandReply))
    message = components.add(msgspec.json.schema(Message))
    refusal = {JSON: {"schema": message}}
    paths = dict(document["paths"])
    for one in catalog.robot.capabilities:
        for path, operations in _paths(one, catalog, components, reply, refusal):
            paths[path] = {**paths.get(path, {}), **operations}
    return {**document, "paths": paths, "components": {**document["components"], "schemas": components.schemas}}


class Components:
    """The schemas of a document by name; if two have one name and differ, the second is renamed."""

    def __init__(self, schemas: Mapping[str, Schema]) -> None:
        self.schemas: dict[str, Schema] = dict(schemas)

    def add(self, schema: Schema) -> Schema:
        """Move a schema's definitions to the document's components; return the schema."""
        names: dict[str, str] = {}
        definitions = {
            name: definition for name, definition in schema.get("$defs", {}).items() if isinstance(definition, dict)
        }
        for name, definition in definitions.items():
            names[name] = self._free(name, _moved(definition, {}))
        for name, definition in definitions.items():
            self.schemas[names[name]] = _moved(definition, names)
        return dict(_moved({key: value for key, value in schema.items() if key != "$defs"}, names))

    def _free(self, name: str, schema: Schema) -> str:
        candidate, number = name, 1
        while candidate in self.schemas and self.schemas[candidate] != schema:
            number += 1
            candidate = f"{name}_{number}"
        return candidate


def _moved(schema: object, names: Mapping[str, str]) -> Any:
    """Return a schema with references to the document's components."""
    if isinstance(schema, dict):
        return {
            key: _reference(value, names) if key == "$ref" else _moved(value, names) for key, value in schema.items()
        }
    return [_moved(one, names) for one in schema] if isinstance(schema, list) else schema


def _reference(reference: object, names: Mapping[str, str]) -> object:
    if not isinstance(reference, str) or not reference.startswith(_DEFS):
        return reference
    name = reference.removeprefix(_DEFS)
    return f"{_COMPONENTS}{names.get(name, name)}"


def _paths(
    part: CapabilityDescription, catalog: Catalog, components: Components, reply: Schema, refusal: Mapping[str, object]
) -> Iterator[tuple[str, dict[str, object]]]:
    for name, schema in part.outputs.items():
        if f"{part.name}/{name}" in catalog.streams:
            yield f"/api/{part.name}/{name}", {"get": _stream(part, name, components.add(schema), refusal)}
    for name, command in part.commands.items():
        body = components.add(command.schema)
        yield f"/api/{part.name}/{name}", {"post": _command(part, name, command, body, reply, refusal)}


def _stream(
    part: CapabilityDescription, name: str, message: Schema, refusal: Mapping[str, object]
) -> dict[str, object]:
    newest = {
        "type": "object",
        "properties": {"age_s": {"type": "number", "minimum": 0}, "message": message},
        "required": ["age_s", "message"],
    }
    return {
        "operationId": f"get_api_{part.name}_{name}",
        "summary": f"The newest of {part.name}/{name}",
        "description": part.summary,
        "tags": [part.name],
        "x-role": "view",
        "security": [{}, {"token": []}],
        "responses": {
            "200": {"description": "The message, and how old it is", "content": {JSON: {"schema": newest}}},
            **_refusals({**openapi.ALWAYS, **openapi.WITH_ROLE, 404: "It has sent nothing yet."}, refusal),
        },
    }


def _command(
    part: CapabilityDescription,
    name: str,
    command: CommandDescription,
    body: Schema,
    reply: Schema,
    refusal: Mapping[str, object],
) -> dict[str, object]:
    held = (
        " It is held by a lease: repeat it with the lease of the answer, ten times a second." if command.leased else ""
    )
    statuses = {**openapi.ALWAYS, **openapi.WITH_ROLE, **openapi.WITH_BODY}
    refused = {400: statuses[400], 409: "The robot refuses it now."}
    return {
        "operationId": f"post_api_{part.name}_{name}",
        "summary": f"Ask {part.name} for {name}",
        "description": f"{part.summary}.{held}",
        "tags": [part.name],
        "x-role": command.role,
        "security": [{}, {"token": []}],
        "requestBody": {"required": False, "content": {JSON: {"schema": body}}},
        "responses": {
            "200": {"description": "What became of it", "content": {JSON: {"schema": _answer(command, reply)}}},
            **_refusals(statuses, refusal),
            **_refusals(refused, {JSON: {"schema": REFUSED}}),
        },
    }


def _answer(command: CommandDescription, reply: Schema) -> Schema:
    """Return the schema of an answer: CommandReply for motion; other answers are known only to their kinds."""
    return reply if command.leased else {"type": "object"}


def _refusals(statuses: Mapping[int, str], refusal: Mapping[str, object]) -> dict[str, object]:
    return {str(status): {"description": why, "content": refusal} for status, why in sorted(statuses.items())}
