import pytest

from lbr.apps.http.pages import Pages
from lbr.apps.web.access import Access
from lbr.apps.web.face import Client, Refused, Request, refuse_without
from lbr.bus import tokens
from lbr.bus.door import LanUser

SECRET = "s" * 43
FINGERPRINT = "f" * 22
HASH = tokens.hashed(SECRET)


def user(name: str, role: str, *, hashed: str = HASH) -> LanUser:
    return LanUser(name=name, role=role, secret=SECRET, hash=hashed)  # type: ignore[arg-type]


def token(name: str, secret: str = SECRET) -> dict[str, str]:
    return {"authorization": f"Bearer {name}.{secret}.{FINGERPRINT}"}


def bearer(name: str) -> dict[str, str]:
    """Return the headers of a user with this secret."""
    return {"Authorization": f"Bearer {name}.{SECRET}.{FINGERPRINT}"}


USERS = (user("ann", "operate"), user("eve", "view", hashed=tokens.hashed("t" * 43)), user("pi4", "host"))
TRUSTED = ("192.168.7.0/24",)
ACCESS, LEGACY = Access(TRUSTED, USERS), Access(TRUSTED, USERS, legacy=True)
HERE = {"host": "127.0.0.1:50000"}


@pytest.mark.parametrize("address", ["127.0.0.1", "127.8.9.1", "::1", "::ffff:127.0.0.1"])
def test_at_this_machine_everybody_looks_and_its_owner_may_everything(address):
    def client(access: Access, **options: bool) -> Client:
        return access.client(address, HERE, port=50000, **options)

    assert client(ACCESS).role == "view"
    assert client(ACCESS, owner=True).role == "admin"
    assert not client(ACCESS, owner=True).legacy
    assert client(LEGACY).role == "operate"
    assert client(LEGACY).legacy
    assert client(Access(("127.0.0.0/8", "::1"), ())).role == "operate"


@pytest.mark.parametrize(
    ("address", "headers", "role"),
    [
        ("192.168.7.9", {}, "operate"),
        ("::ffff:192.168.7.9", {}, "operate"),
        ("192.168.8.9", {}, None),
        ("", {}, None),
        ("127.0.0.1.example.org", {}, None),
        ("8.8.8.8", {"x-forwarded-for": "127.0.0.1"}, None),
        ("8.8.8.8", token("ann"), "operate"),
        ("127.0.0.1", token("ann"), "operate"),
        ("8.8.8.8", token("pi4"), "view"),
    ],
)
def test_who_asks_has_the_role_of_its_network_or_token(address, headers, role):
    for access in (ACCESS, LEGACY):
        assert access.client(address, headers, owner=True).role == role


TRACES = (
    "cdn-loop client-ip cloudfront-viewer-address do-connecting-ip fly-client-ip forwarded-for max-forwards proxy-client-ip "
    "proxy-connection wl-proxy-client-ip x-amzn-trace-id x-appengine-user-ip x-arr-log-id x-azure-fdid x-cluster-client-ip "
    "x-forward-for x-from-ip x-host x-nginx-proxy x-original-url x-originating-ip x-remote-addr x-rewrite-url x-scheme "
    "x-vercel-id x_forwarded_for"
)


@pytest.mark.parametrize(
    "headers",
    [
        {"forwarded": "for=8.8.8.8"},
        {"x-forwarded-for": "127.0.0.1"},
        {"x-forwarded-host": "evil.example"},
        {"x-forwarded-proto": "https"},
        {"x-real-ip": "8.8.8.8"},
        {"via": "1.1 proxy"},
        {"cf-connecting-ip": "8.8.8.8"},
        {"cf-ray": "1"},
        {"true-client-ip": "8.8.8.8"},
        {"x-envoy-external-address": "8.8.8.8"},
        {"tailscale-user-login": "eve"},
        *({name: "8.8.8.8"} for name in TRACES.split()),
        {"host": "localhost:8080"},  # a tunnel that ends at another port
        {"host": "robot.example.org"},  # a proxy that passes on the name it was asked by
        {"host": ""},
    ],
)
def test_what_was_passed_on_is_a_strangers_at_this_machine_too(headers):
    for access in (ACCESS, LEGACY, Access(("0.0.0.0/0", "::/0"), ())):
        client = access.client("127.0.0.1", HERE | headers, port=50000, owner=True)
        assert (client.role, client.legacy) == (None, False)


def test_what_browsers_and_programs_send_of_themselves_is_no_trace_of_a_proxy():
    sent = (
        "accept accept-encoding accept-language access-control-request-headers access-control-request-private-network "
        "cache-control connection content-length content-type cookie dnt if-match if-none-match origin pragma priority range "
        "referer save-data sec-ch-ua sec-ch-ua-mobile sec-ch-ua-platform sec-fetch-dest sec-fetch-mode sec-fetch-site sec-gpc "
        "sec-websocket-extensions sec-websocket-key sec-websocket-protocol sec-websocket-version te transfer-encoding "
        "upgrade upgrade-insecure-requests user-agent x-requested-with"
    )
    headers = HERE | dict.fromkeys(sent.split(), "x")
    assert ACCESS.client("127.0.0.1", headers, port=50000, owner=True).role == "admin"


OLD = f"TOK:ann.{SECRET}.{FINGERPRINT}"


def test_a_token_may_be_shown_as_the_robot_lbrs_old_clients_do():
    for access in (ACCESS, LEGACY):
        for address in ("127.0.0.1", "8.8.8.8"):
            client = access.client(address, HERE | {"user": "me", "authorization": OLD}, port=50000)
            assert (client.name, client.role) == ("ann", "operate")


@pytest.mark.parametrize("shown", ["TOK:", "TOK:" + "x" * 43, "TOK:nonsense"])
def test_a_token_of_the_old_robot_counts_as_none_where_legacy_is_open_alone(shown):
    headers = HERE | {"user": "me", "authorization": shown}
    client = LEGACY.client("127.0.0.1", headers, port=50000)
    assert (client.name, client.role, client.legacy) == ("", "operate", True)
    assert LEGACY.client("8.8.8.8", headers).role is None
    with pytest.raises(Refused, match="token"):
        ACCESS.client("127.0.0.1", headers, port=50000)


@pytest.mark.parametrize(
    "headers",
    [
        {"authorization": OLD.replace("ann", "nobody")},
        {"authorization": OLD.replace("sss", "xxx")},
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


@pytest.mark.parametrize(
    ("client", "proven", "moves"),
    [
        (Client("127.0.0.1", role="admin"), False, False),
        (Client("127.0.0.1", role="admin"), True, True),
        (Client("192.168.7.9", role="operate"), False, False),
        (Client("127.0.0.1", role="operate", legacy=True), False, True),
    ],
)
@pytest.mark.parametrize("method", ["GET", "HEAD"])
def test_a_get_moves_only_what_no_web_page_can_have_sent(client, proven, moves, method):
    ask = Request(method=method, path="/move", client=client, proven=proven)
    ask.require("view")
    if moves:
        ask.require("operate")
        return
    with pytest.raises(Refused, match="Sec-Fetch-Site") as refused:
        ask.require("operate")
    assert refused.value.status == 403
    Request(method="POST", path="/move", client=client).require("operate")


@pytest.mark.parametrize(
    "ahead",
    [
        {"sec-purpose": "prefetch;prerender", "sec-fetch-site": "none"},  # an address that is still being typed
        {"sec-purpose": "prefetch;anonymous-client-ip"},
        {"purpose": "Prefetch"},
        {"x-moz": "prefetch"},
        {"x-purpose": "preview"},
    ],
)
@pytest.mark.parametrize("legacy", [False, True])
def test_a_browser_that_loads_ahead_moves_nothing(ahead, legacy):
    client = Client("127.0.0.1", role="admin", legacy=legacy)
    ask = Request(method="GET", path="/motion/4", client=client, proven=True, headers=ahead)
    ask.require("view")
    with pytest.raises(Refused, match="ahead"):
        ask.require("operate")
    Request(method="GET", path="/motion/4", client=client, proven=True, headers={"purpose": "x"}).require("operate")


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


@pytest.mark.parametrize(
    ("headers", "proven"),
    [
        ({}, False),  # an app, a script, or a browser at plain http that was told to leave out the referrer
        ({"sec-fetch-site": ""}, False),
        ({"sec-fetch-site": "none"}, True),
        ({"sec-fetch-site": "same-origin"}, True),
        ({"origin": "http://robot:50000"}, True),
        ({"referer": "http://robot:50000/demo"}, True),
        ({"referer": "/demo"}, False),
        ({"user-agent": "curl/8"}, False),
    ],
)
def test_only_what_is_said_proves_that_no_foreign_page_asks(headers, proven):
    assert not Pages(()).stranger(OWN | headers, "http")
    assert Pages(()).proven(OWN | headers) is proven
    assert Pages(("*",)).proven(OWN | headers)
