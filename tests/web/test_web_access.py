import pytest

from lbr.apps.web.access import Access, Pages
from lbr.apps.web.face import Client, Refused, refuse_without
from lbr.bus import tokens
from lbr.capability.config import LanUser

SECRET = "s" * 43
FINGERPRINT = "f" * 22
HASH = tokens.hashed(SECRET)


def user(name: str, role: str, *, hashed: str = HASH) -> LanUser:
    return LanUser(name=name, role=role, secret=SECRET, hash=hashed)  # type: ignore[arg-type]


def token(name: str, secret: str = SECRET) -> dict[str, str]:
    return {"authorization": f"Bearer {name}.{secret}.{FINGERPRINT}"}


ACCESS = Access(
    ("127.0.0.0/8", "::1", "192.168.7.0/24"),
    (user("ann", "operate"), user("eve", "view", hashed=tokens.hashed("t" * 43)), user("pi4", "host")),
)


@pytest.mark.parametrize(
    ("address", "headers", "role"),
    [
        ("127.0.0.1", {}, "admin"),
        ("::1", {}, "admin"),
        ("::ffff:127.0.0.1", {}, "admin"),
        ("192.168.7.9", {}, "admin"),
        ("192.168.8.9", {}, None),
        ("", {}, None),
        ("127.0.0.1", {"x-forwarded-for": "8.8.8.8"}, None),
        ("8.8.8.8", {"x-forwarded-for": "127.0.0.1"}, None),
        ("8.8.8.8", token("ann"), "operate"),
        ("127.0.0.1", token("ann"), "operate"),
        ("8.8.8.8", token("pi4"), "view"),
    ],
)
def test_who_asks_has_the_role_of_its_network_or_token(address, headers, role):
    assert ACCESS.client(address, headers).role == role


@pytest.mark.parametrize(
    "headers",
    [
        token("ann", "x" * 43),
        token("nobody"),
        token("eve"),  # its row is of another secret
        {"authorization": "Bearer nonsense"},
        {"authorization": "Basic YTpi"},
        {"authorization": ""},
    ],
)
def test_a_token_that_is_none_is_refused_from_anywhere(headers):
    with pytest.raises(Refused) as refused:
        ACCESS.client("127.0.0.1", headers)
    assert refused.value.status == 401
    assert "WWW-Authenticate" in refused.value.headers
    assert SECRET not in refused.value.message


def test_what_a_role_does_not_allow_is_refused_with_a_sentence():
    refuse_without(Client("a", role="operate"), "view")
    with pytest.raises(Refused, match="needs the role 'admin'") as refused:
        refuse_without(Client("a", name="ann", role="operate"), "admin")
    assert refused.value.status == 403


OWN = {"host": "robot:50000"}


@pytest.mark.parametrize(
    ("headers", "cors", "stranger"),
    [
        ({}, (), ""),  # an app, a script
        ({"sec-fetch-site": "none"}, (), ""),  # typed into a browser
        ({"origin": "http://robot:50000", "sec-fetch-site": "same-origin"}, (), ""),
        ({"referer": "http://robot:50000/demo", "sec-fetch-site": "same-origin"}, (), ""),
        ({"origin": "http://evil.example"}, (), "http://evil.example"),
        ({"origin": ""}, (), "an empty origin"),
        ({"origin": "null"}, (), "null"),
        ({"sec-fetch-site": "cross-site"}, (), "another page"),  # a picture without a referrer
        ({"sec-fetch-site": "same-site"}, (), "another page"),
        ({"referer": "http://evil.example/x"}, (), "http://evil.example"),  # a browser without Sec-Fetch
        ({"origin": "http://app:1"}, ("http://app:1",), ""),
        ({"origin": "http://app:2"}, ("http://app:1",), "http://app:2"),
        ({"referer": "http://app:1/", "sec-fetch-site": "cross-site"}, ("http://app:1",), ""),
        ({"referer": "http://robot:50000/", "sec-fetch-site": "cross-site"}, (), "http://robot:50000"),
        ({"origin": "http://evil.example"}, ("*",), ""),
        ({"referer": "http://["}, (), "an address that cannot be read"),
    ],
)
def test_foreign_pages_are_known_by_what_browsers_say(headers, cors, stranger):
    assert Pages(cors).stranger(OWN | headers, "http") == stranger
