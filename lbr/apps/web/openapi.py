"""The OpenAPI document of the server's routes."""

import re
from collections.abc import Iterable, Mapping
from typing import Any

import msgspec

from lbr.apps.web.contract import Contract, contract
from lbr.apps.web.face import JSON, Message, Route
from lbr.messages.description import Schema

VERSION = "3.1.0"
_TEMPLATE = "#/components/schemas/{name}"
ALWAYS: Mapping[int, str] = {
    400: "Something in it is not as it must be.",
    413: "The body is too large.",
    414: "The address is too long.",
    421: "This machine was asked by a name that is not its own.",
    429: "Too many requests a second.",
    503: "The robot does not answer now.",
}
WITH_ROLE: Mapping[int, str] = {
    401: "A token is needed, or this one is not valid.",
    403: "The token's role does not allow it.",
}
WITH_BODY: Mapping[int, str] = {408: "The body did not come.", 415: "The body is not JSON."}


def document(routes: Iterable[Route], *, title: str, description: str, version: str) -> Schema:
    """Return the document of these routes."""
    documented = [(route, promised) for route in routes if (promised := contract(route)).summary]
    kinds: list[object] = [Message]
    for _route, promised in documented:
        kinds += [kind for kind in (promised.params, promised.body) if kind is not None]
        kinds += [reply for reply in promised.replies.values() if reply is not None and not isinstance(reply, str)]
    kinds = list({id(kind): kind for kind in kinds}.values())
    found, components = msgspec.json.schema_components(kinds, ref_template=_TEMPLATE)
    schemas = {id(kind): schema for kind, schema in zip(kinds, found, strict=True)}
    paths: dict[str, dict[str, object]] = {}
    for route, promised in documented:
        paths.setdefault(route.path, {})[route.method.lower()] = _operation(route, promised, schemas, components)
    return {
        "openapi": VERSION,
        "info": {"title": title, "description": description, "version": version},
        "paths": paths,
        "components": {
            "schemas": components,
            "securitySchemes": {
                "token": {
                    "type": "http",
                    "scheme": "bearer",
                    "description": "NAME.SECRET.FINGERPRINT, as 'lbr token add' prints it; trusted networks need none",
                }
            },
        },
    }


def _operation(
    route: Route, promised: Contract, schemas: Mapping[int, Schema], components: Mapping[str, Schema]
) -> dict[str, object]:
    parameters = [
        {"name": name, "in": "path", "required": True, "schema": {"type": "string", "minLength": 1}}
        for name in promised.keys
    ]
    operation: dict[str, object] = {
        "operationId": _operation_id(route),
        "summary": promised.summary,
        **({"description": promised.description} if promised.description else {}),
        "x-role": route.least or "anybody",
        "security": [{}, {"token": []}] if route.role is not None else [{}],
        "responses": _responses(route, promised, schemas),
    }
    if promised.params is not None:
        parameters += _query(schemas[id(promised.params)], components)
    if parameters:
        operation["parameters"] = parameters
    if promised.body is not None:
        operation["requestBody"] = {
            "required": promised.body_required,
            "content": {JSON: {"schema": schemas[id(promised.body)]}},
        }
    return operation


def _query(schema: Schema, components: Mapping[str, Schema]) -> list[dict[str, object]]:
    whole = components[schema["$ref"].rpartition("/")[2]]
    required = set(whole.get("required", ()))
    return [
        {
            "name": name,
            "in": "query",
            "required": name in required,
            "schema": {key: value for key, value in each.items() if key != "description"},
            **({"description": each["description"]} if "description" in each else {}),
        }
        for name, each in whole.get("properties", {}).items()
    ]


def _responses(route: Route, promised: Contract, schemas: Mapping[int, object]) -> dict[str, Any]:
    message = {JSON: {"schema": schemas[id(Message)]}}
    refusals = {
        **ALWAYS,
        **(WITH_ROLE if route.role is not None else {403: WITH_ROLE[403]}),
        **(WITH_BODY if promised.body is not None and route.stops is not True else {}),
        **promised.refuses,
    }
    responses = {
        str(status): {"description": promised.summary} | _content(reply, schemas)
        for status, reply in promised.replies.items()
    }
    responses |= {
        str(status): {"description": why, "content": message}
        for status, why in refusals.items()
        if str(status) not in responses
    }
    return dict(sorted(responses.items()))


def _content(reply: object, schemas: Mapping[int, object]) -> dict[str, Any]:
    if reply is None:
        return {}
    if isinstance(reply, str):
        return {"content": {reply: {"schema": {"type": "string"}}}}
    return {"content": {JSON: {"schema": schemas[id(reply)]}}}


def _operation_id(route: Route) -> str:
    words = re.findall(r"[A-Za-z0-9]+", route.path) or ["root"]
    return "_".join((route.method.lower(), *words))
