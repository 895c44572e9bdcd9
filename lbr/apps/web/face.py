"""Faces: methods declared as routes, and a step in the capability's loop.

A route's answers, and its part of the OpenAPI document, come from its method's signature and docstring: see `contract`.
A face lives on one thread, in the capability's loop. It runs `step`, `stopped` and each handler that is a coroutine.
A plain function answers at once on the server's thread; it may read constant data only.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cache, partial
from importlib import resources
from math import inf
from typing import Any, Literal, TypedDict, TypeVar, Unpack

import msgspec
from msgspec import Struct
from starlette.responses import Response

from lbr.apps.http.pages import is_ahead
from lbr.messages.codes import Code, Reason, ReasonCode
from lbr.messages.system import RANKS, Role

Method = Literal["GET", "POST", "PUT", "PATCH", "DELETE", "OPTIONS"]
JSON, HTML, TEXT, SVG = "application/json", "text/html", "text/plain", "image/svg+xml"
SCRIPT, STYLE = "text/javascript", "text/css"
ANSWER_S = 2.0
_encode = msgspec.json.Encoder().encode


CODES: dict[int, Code] = {
    400: "bad_value",
    401: "token",
    403: "role",
    404: "unknown_name",
    405: "not_possible",
    408: "timeout",
    412: "changed",
    413: "bad_value",
    414: "bad_value",
    415: "bad_value",
    421: "denied",
    429: "busy",
    500: "failed",
    503: "unreachable",
}
"""The code of a refusal by its status, unless the refusal has its own code."""


class Message(Struct, frozen=True, kw_only=True, omit_defaults=True):
    """The problem, as a sentence and by its code."""

    message: str
    code: ReasonCode = ""


class Refused(Exception):  # noqa: N818 - an answer, not a fault
    """An answer `{"message": ..., "code": ...}` with a status, raised at any depth.

    The code is the argument, else the code of the `Reason`, else the status's. The header `Reason-Code` has it, too.
    """

    def __init__(
        self, status: int, message: str | Reason, headers: Mapping[str, str] | None = None, code: Code | None = None
    ) -> None:
        super().__init__(str(message))
        self.status = status
        self.message = str(message)
        own = message.code if isinstance(message, Reason) else None
        self.code: Code = code or own or CODES.get(status, "refused")
        self.headers = dict(headers or {})

    def response(self) -> Response:
        """Return the refusal as a response."""
        message = Message(message=self.message, code=self.code)
        return json(message, self.status, **{"Reason-Code": self.code, **self.headers})


@dataclass(frozen=True, slots=True)
class Client:
    """The client: its address, the name of its token (empty: without one), and its role (None: no rights).

    - `legacy`: the row allows it to move by a GET that a web page may have sent.
    - `session`: the mark of the session of its cookie.
    - `whose`: the user of its program as the kernel reports it; empty for another machine.
    """

    address: str
    name: str = ""
    role: Role | None = None
    legacy: bool = False
    session: str = ""
    whose: str | None = None

    @property
    def known(self) -> bool:
        """Return whether the client is identified by a token, a cookie, or as this robot's own user, not by its place
        alone."""
        return bool(self.name or self.session) or self.role == "admin"

    @property
    def mark(self) -> str:
        """Return what identifies its session, or else its token; empty without one."""
        return self.session or self.name

    def may(self, role: Role | None) -> bool:
        """Return whether this client has a role; None is for everybody."""
        return role is None or (self.role is not None and RANKS[self.role] >= RANKS[role])

    def __str__(self) -> str:
        name = self.mark.partition(":")[0]
        return f"{name} at {self.address}" if name else self.address


Query = tuple[tuple[str, str], ...]
"""A query's parameters in their order; a name may repeat."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Request:
    """A request with its `query`, and its `body` if the route takes one.

    - `proven`: a foreign web page cannot have sent it.
    - `came_s`: the monotonic time at which its head was read; infinite for now.
    """

    method: str
    path: str
    client: Client
    proven: bool = False
    query: Query = ()
    headers: Mapping[str, str] = field(default_factory=dict)
    body: bytes = b""
    came_s: float = inf

    def require(self, role: Role) -> None:
        """Raise Refused unless the client has the role, and meant the request.

        The server calls it for a route's least role; a route calls it if some requests need more. A GET for more
        than looking must be proven not to be a foreign page's. Browsers send one for any page's picture, and some do
        not mark it. A GET that a browser sends ahead of its user's click is refused.
        """
        refuse_without(self.client, role)
        moves = self.method in {"GET", "HEAD"} and RANKS[role] > RANKS["view"]
        if moves and is_ahead(self.headers):
            raise Refused(403, "a browser loads this ahead: nothing moves until its user asks for it", code="denied")
        if moves and not (self.proven or self.client.legacy):
            raise Refused(
                403,
                "a GET that moves must not come from a web page: use POST, show a token, send 'Sec-Fetch-Site: none',"
                " or open the old API by the setting 'legacy' of the row",
                code="denied",
            )


def refuse_without(client: Client, role: Role | None) -> None:
    """Raise Refused unless a client has the role."""
    if client.may(role):
        return
    if client.name:
        raise Refused(403, f"this needs the role '{role}', and the token '{client.name}' has '{client.role}'")
    text = (
        f"{client.address} is not among the trusted networks"
        if client.role is None
        else f"{client.address} has the role '{client.role}' without a token, and this needs '{role}'"
    )
    raise Refused(
        401,
        f"{text}: show a token, 'Authorization: Bearer NAME.SECRET.FINGERPRINT', of 'lbr token add NAME --for web'",
        {"WWW-Authenticate": 'Bearer realm="lbr"'},
    )


def refuse_unknown(client: Client) -> None:
    """Raise Refused unless a client is known."""
    if not client.known:
        text = "this needs a token: send it as, 'Authorization: Bearer TOKEN', or sign in at /index.html"
        raise Refused(401, text, {"WWW-Authenticate": 'Bearer realm="lbr"'})


def json(data: object, status: int = 200, **headers: str) -> Response:
    """Return a JSON response, keys in their order; a header's `_` stands for `-`."""
    return encoded(_encode(data), status, **headers)


def encoded(content: bytes, status: int = 200, **headers: str) -> Response:
    """Return a JSON response of encoded bytes."""
    return Response(content, status, _named(headers), f"{JSON}; charset=utf-8")


def text(content: str, status: int = 200, media: str = TEXT, **headers: str) -> Response:
    """Return a text response, plain or of another media type."""
    return Response(content, status, _named(headers), media)


def static(package: str, name: str, media: str = HTML, status: int = 200, **headers: str) -> Response:
    """Return a file of a package's folder `pages`."""
    return text(_content(package, name), status, media, **headers)


@cache
def _content(package: str, name: str) -> str:
    return (resources.files(package) / "pages" / name).read_text(encoding="utf-8")


def _named(headers: Mapping[str, str]) -> dict[str, str]:
    return {name.replace("_", "-"): value for name, value in headers.items()}


@dataclass(frozen=True, slots=True, kw_only=True)
class Route:
    """One method of one path, such as `/motion/{key}` or `/files/{rest:path}`, with its handler and its rights.

    - `handle`: its signature is the contract. A coroutine answers in the capability's loop, a plain function at once.
    - `role`: the least role; None admits everybody, `known` admits known clients (`Client.known`).
    - `page`: a link from any other page may open it, so it must change nothing. Foreign pages reach no other route.
    - `accept`: a media type, such as `text/html`. For clients that name it in `Accept` the route comes first.
    - `stops`: the handler runs whatever the body is; a late, too large or malformed body becomes None. A function
      decides by the path's keys and the body; the handler then runs even if the sender has left.
    - `within_s`: the time for a coroutine's answer; after it the status is 503.
    """

    method: Method
    path: str
    handle: Callable[..., Any]
    role: Role | Literal["known"] | None = "view"
    page: bool = False
    accept: str = ""
    stops: bool | Callable[[Mapping[str, Any]], bool] = False
    within_s: float = ANSWER_S

    @property
    def least(self) -> Role | None:
        """Return the least role, without `known`."""
        return "view" if self.role == "known" else self.role

    def refused(self, err: Refused) -> Response:
        """Return the response for a refusal; subclasses may change its form."""
        return err.response()


class Options(TypedDict, total=False):
    """The options of a route besides its method and path: see `Route`."""

    role: Role | Literal["known"] | None
    page: bool
    accept: str
    stops: bool | Callable[[Mapping[str, Any]], bool]
    within_s: float


H = TypeVar("H", bound=Callable[..., object])


def route(method: Method, path: str, kind: type[Route] = Route, **options: Unpack[Options]) -> Callable[[H], H]:
    """Declare a method as the handler of a route; one method may handle several."""

    def declare(handle: H) -> H:
        vars(handle).setdefault("routes", []).insert(0, kind(method=method, path=path, handle=handle, **options))
        return handle

    return declare


get, post = partial(route, "GET"), partial(route, "POST")


def declared(owner: object) -> list[Route]:
    """Return the routes that an object's methods handle, in the order of their declaration."""
    methods = [
        (name, vars(method)["routes"]) for name, method in vars(type(owner)).items() if hasattr(method, "routes")
    ]
    return [replace(one, handle=getattr(owner, name)) for name, routes in methods for one in routes]


class Face:
    """A way to show the robot; subclass it.

    A component's `faces` names the function that makes it: `face(robot) -> Face`.
    """

    name: str = ""

    def routes(self) -> Sequence[Route]:
        """Return its routes; called once."""
        return declared(self)

    def step(self, now: float) -> None:
        """Do one round of work, in the capability's loop; must not block."""

    def knows(self) -> bool:
        """Return whether it has the data that its clients request first; the server waits some seconds for it to be
        ready."""
        return True

    def stopped(self, reason: str) -> None:
        """Drop pending work: the robot was stopped by way of this server, or the server ends."""

    def close(self) -> None:
        """End all that goes on by itself, such as streams, as the server ends."""

    def state(self) -> Mapping[str, object]:
        """Return its part of the stream of states; called often, in the capability's loop."""
        return {}

    @property
    def jobs(self) -> int:
        """Return the number of jobs that wait or are under way."""
        return 0
