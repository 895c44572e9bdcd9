"""What a face is: declared routes, from which both the answers and the OpenAPI document come, and a share of the loop.

A face lives in the capability's loop, on one thread: there run `step`, `stopped` and each handler that is a coroutine.
A handler that is a plain function is answered on the server's thread at once; it may read only what does not change.
"""

from collections.abc import Callable, Coroutine, Mapping, Sequence
from dataclasses import dataclass, field
from math import inf
from typing import Any, Literal

import msgspec
from msgspec import Struct
from starlette.responses import Response

from lbr.apps.http.pages import is_ahead
from lbr.messages.codes import Code, Reason, ReasonCode
from lbr.messages.system import RANKS, Role

Method = Literal["GET", "POST", "PUT", "PATCH", "DELETE", "OPTIONS"]
JSON, HTML, TEXT, SVG = "application/json", "text/html", "text/plain", "image/svg+xml"
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
"""Why a request is refused with a status, unless it is told closer."""


class Message(Struct, frozen=True, kw_only=True, omit_defaults=True):
    """What was wrong, as a sentence and by its code."""

    message: str
    code: ReasonCode = ""


class Refused(Exception):  # noqa: N818 - an answer, not a fault
    """An answer `{"message": ..., "code": ...}` with a status, from wherever it is noticed.

    A `Reason` brings its own code; else it is the one given, or what the status says. The code is in the header
    `Reason-Code` as well, and there alone if the body must be `bare`, as older clients know it.
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
        self.bare = False


@dataclass(frozen=True, slots=True)
class Client:
    """Who asks: from which address, by which token (empty: by none), and what that allows (None: nothing).

    `legacy`: the row lets a GET move that nothing proves to be no web page's. `session` is what is kept of the cookie
    that a browser was given for a token. `whose` program asks, the kernel says: a user's of this machine, or of another
    machine (empty).
    """

    address: str
    name: str = ""
    role: Role | None = None
    legacy: bool = False
    session: str = ""
    whose: str | None = None

    @property
    def known(self) -> bool:
        """Return whether it is known who that is: by a token, a cookie, or as this robot's own user, and not by a place
        alone."""
        return bool(self.name or self.session) or self.role == "admin"

    def may(self, role: Role | None) -> bool:
        """Say whether this client may do what needs a role; None is for everybody."""
        return role is None or (self.role is not None and RANKS[self.role] >= RANKS[role])

    def __str__(self) -> str:
        name = self.name or self.session.partition(":")[0]
        return f"{name} at {self.address}" if name else self.address


@dataclass(frozen=True, slots=True, kw_only=True)
class Request:
    """A request: `keys` out of the path, `query` as it came, `params` and `data` as the route declares them.

    Of a route that is `lenient`, `params` and `data` are None: it reads `query` and `body` itself. `proven`: no foreign
    web page can have sent it. `came_s` is when its head was read, by the monotonic clock; infinite is just now.
    """

    method: str
    path: str
    client: Client
    proven: bool = False
    keys: Mapping[str, str] = field(default_factory=dict)
    query: tuple[tuple[str, str], ...] = ()
    headers: Mapping[str, str] = field(default_factory=dict)
    body: bytes = b""
    params: Any = None
    data: Any = None
    came_s: float = inf

    def require(self, role: Role) -> None:
        """Raise Refused unless the request may do what needs a role.

        Routes call it that need more of some requests than of others; for what every request needs the server does.
        A GET that does more than look must be proven to be no foreign page's: browsers send it for any page's picture,
        and not every browser says so. One that loads ahead says that no user asked for it yet.
        """
        refuse_without(self.client, role)
        moves = self.method in {"GET", "HEAD"} and RANKS[role] > RANKS["view"]
        if moves and is_ahead(self.headers):
            raise Refused(403, "a browser loads this ahead: nothing moves until its user asks for it", code="denied")
        if moves and not (self.proven or self.client.legacy):
            raise Refused(
                403,
                "a GET that moves must show that no web page sent it: use POST, show a token, say 'Sec-Fetch-Site: none',"
                " or open the old API by the setting 'legacy' of the row",
                code="denied",
            )


def refuse_without(client: Client, role: Role | None) -> None:
    """Raise Refused unless a client may do what needs a role."""
    if client.may(role):
        return
    if client.name:
        raise Refused(403, f"this needs the role '{role}', and the token '{client.name}' has '{client.role}'")
    who = (
        f"{client.address} is not among the trusted networks"
        if client.role is None
        else f"{client.address} has the role '{client.role}' without a token, and this needs '{role}'"
    )
    raise Refused(
        401,
        f"{who}: show a token, 'Authorization: Bearer NAME.SECRET.FINGERPRINT'; 'lbr token add NAME --for web' makes one",
        {"WWW-Authenticate": 'Bearer realm="lbr"'},
    )


def refuse_unknown(client: Client) -> None:
    """Raise Refused unless it is known who a client is."""
    if not client.known:
        text = "this is for who is known: show the token, 'Authorization: Bearer TOKEN', or sign in at /index.html"
        raise Refused(401, text, {"WWW-Authenticate": 'Bearer realm="lbr"'})


def json(data: Any, status: int = 200, **headers: str) -> Response:
    """Return an answer in JSON, keys in the order that they have; a header's `_` stands for `-`."""
    return encoded(_encode(data), status, **headers)


def encoded(content: bytes, status: int = 200, **headers: str) -> Response:
    """Return an answer in JSON that is bytes already."""
    return Response(content, status, _named(headers), f"{JSON}; charset=utf-8")


def text(content: str, status: int = 200, media: str = TEXT, **headers: str) -> Response:
    """Return an answer that is plain text, or other text by its media type."""
    return Response(content, status, _named(headers), media)


def html(content: str, status: int = 200, **headers: str) -> Response:
    """Return a page; whatever came from outside must have been escaped."""
    return text(content, status, HTML, **headers)


def _named(headers: Mapping[str, str]) -> dict[str, str]:
    return {name.replace("_", "-"): value for name, value in headers.items()}


@dataclass(frozen=True, slots=True, kw_only=True)
class Route:
    """One method of one path, such as `/motion/{key}` or `/files/{rest*}`: what it takes and returns, who may, who
    answers.

    `params` are the query's; `body` is JSON. The server refuses what does not fit them, unless the route is `lenient`
    and reads them itself: then they only say in the document what is meant, and a body is passed on unread. What one
    that is `bare` refuses is told by its sentence alone, as clients of the old API know it. One that is `regardless` is
    done whatever its body is: of one that is late, too large or wrong, `data` is None. `stops` says of a path's keys
    and of what was said whether that is a stop: it is done although its sender has left meanwhile. `handle` returns an
    answer: a coroutine does so in the capability's loop, within `within_s` (else 503), a plain function at once.
    `replies` maps each status to what is then returned: a Struct, a media type, or None for no content; refusals need
    not be named. `role` is the least that is needed, None for no role. A `page` may be opened by a link from any other
    page, so it must change nothing; everything else is refused to foreign pages. A `hidden` route is not in the
    document. What is `private` is for who is known (`Client.known`); `otherwise` is the page that others get, to sign
    in. One that `signs_in` gives a cookie, so that it is looked up whose program asks. With `accept`, it is first for
    who names that media type in `Accept`, such as a browser `text/html`; another route may answer all others at the
    same path.
    """

    method: Method
    path: str
    handle: Callable[[Request], Response | Coroutine[Any, Any, Response]]
    summary: str
    replies: Mapping[int, Any]
    description: str = ""
    params: type[Struct] | None = None
    body: Any = None
    body_required: bool = True
    lenient: bool = False
    bare: bool = False
    regardless: bool = False
    stops: Callable[[Mapping[str, str], Any], bool] | None = None
    role: Role | None = "view"
    page: bool = False
    private: bool = False
    signs_in: bool = False
    otherwise: Callable[[], Response] | None = None
    hidden: bool = False
    accept: str = ""
    within_s: float = ANSWER_S
    refuses: Mapping[int, str] = field(default_factory=dict)
    """Statuses that this route refuses with besides the server's own, each with when."""


class Face:
    """A way to show the robot; subclass it. A component's `faces` names what makes it: `face(robot) -> Face`."""

    name: str = ""

    def routes(self) -> Sequence[Route]:
        """Return what it answers; asked for once."""
        return ()

    def step(self, now: float) -> None:
        """Do one round of work, in the capability's loop; must not block."""

    def knows(self) -> bool:
        """Say whether it has heard what its clients ask for first; for some seconds the server is not called ready
        before."""
        return True

    def stopped(self, reason: str) -> None:
        """Forget what is waiting to be done: the robot was stopped by way of this server, or it ends."""

    def close(self) -> None:
        """End what goes on by itself, such as streams: the server ends."""

    def state(self) -> Mapping[str, Any]:
        """Return what belongs into the stream of states besides the robot's own; from the capability's loop, often."""
        return {}

    @property
    def jobs(self) -> int:
        """Return how many jobs wait or are under way."""
        return 0
