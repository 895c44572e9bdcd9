"""The contract of a route, from its handler's signature and docstring.

The parameters:

- `request`, `client`: the request and its sender.
- `whose`: the user of the sender's program.
- the keys of the path, by their names; `id` as `id_`.
- `params`: a Struct of the query's parameters.
- `body`: the type of the JSON body, optional with `| None`. A query or body of another type is refused.
- `query: Annotated[Query, X]`, `body: Annotated[bytes, X]`: passed on unread; the document gives `X` as their type.

The return type:

- Any value is sent as JSON, None as no content. A `Response` is sent unchanged.
- `Annotated[Response, "image/svg+xml"]` names its media type, `Annotated[Response, {201: X, 304: None}]` its statuses.
- `Refuses` adds the statuses of refusals to the server's own.

A docstring is the summary and the description. Without one, or with a key for any path, a route is not documented.
"""

import inspect
import re
from collections.abc import Mapping
from dataclasses import dataclass
from types import NoneType
from typing import Annotated, Any, get_args, get_origin

from msgspec import Struct
from starlette.responses import Response

from lbr.apps.web.face import Route, json

KEY = re.compile(r"\{([a-z_]+)(?::path)?\}")
_OFFERED = frozenset({"request", "client", "whose", "query", "params", "body"})


class Refuses(dict[int, str]):
    """The statuses that a route refuses with, and the reason for each."""


@dataclass(frozen=True, slots=True)
class Contract:
    """A route's contract: `reads` and `decodes` state whether `params` and `body` are converted for the handler."""

    takes: frozenset[str]
    keys: tuple[str, ...]
    params: type[Struct] | None
    reads: bool
    body: Any
    decodes: bool
    body_required: bool
    replies: Mapping[int, object]
    refuses: Mapping[int, str]
    summary: str
    description: str
    waits: bool
    """True for a coroutine."""


def contract(route: Route) -> Contract:
    """Return the contract of a route's handler; raise TypeError for a parameter that no request has."""
    signature = inspect.signature(route.handle, eval_str=True)
    given = signature.parameters
    keys = tuple(KEY.findall(route.path))
    if unknown := {name.removesuffix("_") for name in given} - _OFFERED - set(keys):
        raise TypeError(f"{route.method} {route.path} takes {', '.join(sorted(unknown))}, which no request has")
    params, query = _annotated(given, "params"), _annotated(given, "query")
    body = _annotated(given, "body")
    alternatives = get_args(body[0])
    required = NoneType not in alternatives
    decodes = "body" in given and body[0] is not bytes
    documented = body[0] if decodes else next(iter(body[1:]), None)
    if not required:
        documented = next(kind for kind in alternatives if kind is not NoneType)
    replies, refuses = _returned(signature.return_annotation)
    summary, _, description = (inspect.getdoc(route.handle) or "").partition("\n\n")
    return Contract(
        takes=frozenset(given),
        keys=keys,
        params=params[0] or next(iter(query[1:]), None),
        reads="params" in given,
        body=documented,
        decodes=decodes,
        body_required=required,
        replies=replies,
        refuses=refuses,
        summary="" if ":path}" in route.path else " ".join(summary.split()).removesuffix("."),
        description=" ".join(description.split()),
        waits=inspect.iscoroutinefunction(inspect.unwrap(route.handle)),
    )


def response(answer: object) -> Response:
    """Return the response for a handler's return value."""
    if isinstance(answer, Response):
        return answer
    return Response(status_code=204) if answer is None else json(answer)


def _annotated(given: Mapping[str, inspect.Parameter], name: str) -> tuple[Any, ...]:
    """Return a parameter's type and its annotations; (None,) without that parameter."""
    if name not in given:
        return (None,)
    annotation = given[name].annotation
    return get_args(annotation) if get_origin(annotation) is Annotated else (annotation,)


def _returned(annotation: object) -> tuple[dict[int, object], Refuses]:
    """Return the type for each status of success, and the statuses of refusals."""
    kind, *marks = get_args(annotation) if get_origin(annotation) is Annotated else (annotation,)
    replies: dict[int, object] = {}
    if kind not in {Response, inspect.Signature.empty}:
        replies = {204: None} if kind in {None, NoneType} else {200: kind}
    refuses = Refuses()
    for mark in marks:
        if isinstance(mark, Refuses):
            refuses |= mark
        else:
            replies |= {200: mark} if isinstance(mark, str) else mark
    return replies, refuses
