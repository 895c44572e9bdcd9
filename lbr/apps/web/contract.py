"""What a handler's signature says: what it takes of a request, what it returns, and what the document tells of it.

Its parameters are what it is called with. `request` and `client` are who asks, `whose` is whose program that is; the
path's keys come by their names, `id` as `id_`. `params` is a Struct of the query's parameters, `body` what the JSON is, optional with
`| None`: what does not fit is refused. `query: Annotated[Query, X]` and `body: Annotated[bytes, X]` are passed on as
they came; `X` is what the document says they are.

What it returns is sent as JSON, None as no content. A `Response` is sent as it is: `Annotated[Response, "image/svg+xml"]`
names its media type, `Annotated[Response, {201: X, 304: None}]` what is returned with which status. `Refuses` names the
statuses that it refuses with besides the server's own, each with when. The docstring's first line is the summary, the
rest the description; without one, or with a key that takes any path, a route is not in the document.
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
    """Statuses that a route refuses with, each with when."""


@dataclass(frozen=True, slots=True)
class Contract:
    """`reads` and `decodes` are whether `params` and `body` are converted for the handler."""

    takes: frozenset[str]
    keys: tuple[str, ...]
    params: type[Struct] | None
    reads: bool
    body: Any
    decodes: bool
    body_required: bool
    replies: Mapping[int, Any]
    refuses: Mapping[int, str]
    summary: str
    description: str
    waits: bool
    """Whether the handler is a coroutine."""


def contract(route: Route) -> Contract:
    """Return what a route's handler promises; TypeError for what no request has."""
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


def response(answer: Any) -> Response:
    """Return what a handler answers as it is sent."""
    if isinstance(answer, Response):
        return answer
    return Response(status_code=204) if answer is None else json(answer)


def _annotated(given: Mapping[str, inspect.Parameter], name: str) -> tuple[Any, ...]:
    """Return a parameter's type and what it is annotated with; (None,) without that parameter."""
    if name not in given:
        return (None,)
    annotation = given[name].annotation
    return get_args(annotation) if get_origin(annotation) is Annotated else (annotation,)


def _returned(annotation: Any) -> tuple[dict[int, Any], Refuses]:
    """Return what is returned with which status, and when what is refused."""
    kind, *marks = get_args(annotation) if get_origin(annotation) is Annotated else (annotation,)
    replies: dict[int, Any] = {}
    if kind not in {Response, inspect.Signature.empty}:
        replies = {204: None} if kind in {None, NoneType} else {200: kind}
    refuses = Refuses()
    for mark in marks:
        if isinstance(mark, Refuses):
            refuses |= mark
        else:
            replies |= {200: mark} if isinstance(mark, str) else mark
    return replies, refuses
