import json as json_
from typing import Annotated, Any

import pytest
from hypothesis import given
from hypothesis import strategies as st
from msgspec import Struct
from starlette.responses import Response
from starlette.routing import Match

from lbr.apps.web import openapi, routing
from lbr.apps.web.application import Endpoint, methods
from lbr.apps.web.contract import Refuses
from lbr.apps.web.face import TEXT, Client, Message, Query, Refused, Route, declared, get, json, post, route, text
from lbr.apps.web.streams import StreamParams
from lbr.messages.units import Name


class Body(Struct, forbid_unknown_fields=True):
    count: int


class Named(Struct):
    name: Name


def nothing() -> None:
    return None


def of(method: Any, path: str) -> Route:
    return Route(method=method, path=path, handle=nothing)


NOBODY: Any = None
TABLE = [
    Endpoint(one, NOBODY, NOBODY)
    for one in (of("GET", "/"), of("GET", "/motion"), of("GET", "/motion/{key}"), of("POST", "/stop"))
]


def find(method: str, path: str) -> tuple[str, dict[str, str]] | None:
    """Return the route that a request gets and the keys in its path, as Starlette's router asks for them."""
    scope = {"type": "http", "method": method, "raw_path": path.encode()}
    for endpoint in TABLE:
        match, found = endpoint.matches(scope)
        if match is Match.FULL:
            return endpoint.route.path, found["path_params"]
    return None


@pytest.mark.parametrize(
    ("method", "path", "found"),
    [
        ("GET", "/", ("/", {})),
        ("GET", "/Motion/", ("/motion", {})),
        ("GET", "/motion/Basic_Motion", ("/motion/{key}", {"key": "Basic_Motion"})),
        ("GET", "/MOTION/a%2Fb/", ("/motion/{key}", {"key": "a/b"})),
        ("HEAD", "/motion", ("/motion", {})),
        ("GET", "/motion//", None),
        ("GET", "/motion/a/b", None),
        ("POST", "/motion", None),
        ("PUT", "/stop", None),
        ("GET", "/motio", None),
    ],
)
def test_a_path_is_found_in_either_case_and_with_a_slash_at_its_end(method, path, found):
    assert find(method, path) == found


@pytest.mark.parametrize(
    ("path", "asked", "rest"),
    [
        ("/files/{rest:path}", "/files/a/b.txt", "a/b.txt"),
        ("/files/{rest:path}", "/files/", ""),
        ("/files/{rest:path}", "/files", None),
        ("/files{rest:path}", "/files", ""),
        ("/files{rest:path}", "/FILES/%41", "/A"),
        ("/{rest:path}", "/", ""),
        ("/{rest:path}", "/a//b/", "a//b/"),
    ],
)
def test_a_key_of_the_kind_path_is_all_that_follows(path, asked, rest):
    found = routing.Path(path)
    assert found.fits(asked) is (rest is not None)
    assert found.keys(asked) == ({} if rest is None else {"rest": rest})


def test_a_path_knows_its_methods():
    assert methods(TABLE, "/STOP/") == ("POST",)
    assert methods(TABLE, "/motion") == ("GET", "HEAD")
    assert methods(TABLE, "/nope") == ()


def test_a_key_that_is_no_text_is_refused():
    with pytest.raises(Refused) as refused:
        find("GET", "/motion/%ff")
    assert refused.value.status == 400


def refusal_of(work) -> int | None:
    try:
        work()
    except Refused as err:
        return err.status if err.message else 0
    return None


@given(st.binary(max_size=300), st.text(max_size=60))
def test_whatever_is_asked_is_answered_or_refused(query, path):
    assert refusal_of(lambda: routing.converted(routing.parameters(query), StreamParams)) in {None, 400}
    assert refusal_of(lambda: find("GET", f"/{path}")) in {None, 400}


@given(st.binary(max_size=300))
def test_whatever_a_body_holds_is_read_or_refused(body):
    assert refusal_of(lambda: routing.decoded(body, Body)) in {None, 400}


@pytest.mark.parametrize(
    ("query", "said"),
    [
        (b"rate_hz=x", "rate_hz: Expected 'float'"),
        (b"rate_hz=0", "rate_hz: Expected 'float' >= 0.1"),
        (b"rate_hz=1&rate_hz=2", "'rate_hz' may be given once"),
        (b"&".join(b"a=1" for _ in range(99)), "64 parameters"),
    ],
)
def test_a_parameter_that_does_not_fit_is_named(query, said):
    with pytest.raises(Refused) as refused:
        routing.converted(routing.parameters(query), StreamParams)
    assert said in refused.value.message


def test_what_is_no_name_is_told_in_words(wording):
    with wording.of(Refused):
        routing.decoded(b'{"name": "Nod"}', Named)


def test_what_is_nested_too_deeply_is_refused():
    with pytest.raises(Refused):
        routing.decoded(b"[" * 60_000, Body)


class Things:
    """What a signature can say, once each."""

    @get("/motion/{key}")
    async def motion(self, key: str, params: StreamParams) -> Annotated[Message, Refuses({409: "busy"})]:
        """Show a motion.

        By its number,
        or its name.
        """
        return Message(message=f"{key} at {params.rate_hz}")

    @post("/things", role="admin")
    async def make(self, client: Client, body: Body) -> Annotated[Response, {201: Message}]:
        """Make a thing."""
        return json(Message(message=f"{client} makes {body.count}"), 201)

    @get("/old")
    @post("/old")
    def old(self, query: Annotated[Query, StreamParams], body: Annotated[bytes, Body]) -> Annotated[Response, TEXT]:
        """Read what came as it came."""
        return text(f"{query} {body!r}")

    @route("DELETE", "/things/{id}", role="known")
    def end(self, id_: str, body: Body | None = None) -> None:
        """End a thing."""

    @get("/hidden")
    def hidden(self) -> Message:
        return Message(message="")

    @get("/any/{path:path}")
    def whatever(self) -> Message:
        """Answer at any path."""
        return Message(message="")


def test_the_document_is_made_of_signatures_and_docstrings():
    made = json_.loads(json_.dumps(openapi.document(declared(Things()), title="t", description="d", version="1")))
    assert list(made["paths"]) == ["/motion/{key}", "/things", "/old", "/things/{id}"]
    moved = made["paths"]["/motion/{key}"]["get"]
    assert (moved["summary"], moved["description"]) == ("Show a motion", "By its number, or its name.")
    assert [(one["name"], one["in"], one["required"]) for one in moved["parameters"]] == [
        ("key", "path", True),
        ("rate_hz", "query", False),
    ]
    assert moved["parameters"][1]["schema"]["maximum"] == 50.0
    assert {"200", "400", "401", "403", "409", "429"} <= set(moved["responses"])
    made_one = made["paths"]["/things"]["post"]
    assert made_one["x-role"] == "admin"
    assert made_one["requestBody"]["required"]
    assert "201" in made_one["responses"]
    assert made["components"]["schemas"]["Body"]["additionalProperties"] is False
    assert set(made["paths"]["/old"]) == {"get", "post"}
    old = made["paths"]["/old"]["post"]
    assert [one["name"] for one in old["parameters"]] == ["rate_hz"]
    assert old["requestBody"]["content"]["application/json"]["schema"] == {"$ref": "#/components/schemas/Body"}
    assert "text/plain" in old["responses"]["200"]["content"]
    ended = made["paths"]["/things/{id}"]["delete"]
    assert (ended["x-role"], ended["requestBody"]["required"]) == ("view", False)
    assert "content" not in ended["responses"]["204"]


def test_a_handler_that_takes_what_no_request_has_is_refused():
    class Wrong:
        @get("/motion/{key}")
        def motion(self, name: str) -> None: ...

    with pytest.raises(TypeError, match=r"GET /motion/\{key\} takes name, which no request has"):
        openapi.document(declared(Wrong()), title="", description="", version="")


@pytest.mark.parametrize("body", [b'{"count":', b"count=1", b"", b"not"])
def test_a_body_that_is_not_json_is_named_as_that(body):
    with pytest.raises(Refused, match=r"the body is not JSON: ."):
        routing.decoded(body, Body)
