"""Zenoh sessions: one router in the executive, clients everywhere else; no scouting, nothing beyond what is named."""

# ruff: noqa: E402 - the library must not find a shell's settings

import base64
import json
import os
import resource
from collections.abc import Sequence
from typing import Any

# Few runtime threads are enough for a leaf process and save it latency and CPU; a router collapses with them. Received
# messages have threads of their own: an answer given there waits for the sender, and would wait for itself. So threads
# that read (rx) do not watch sockets (app, acc), though each message wakes two threads so. With both waiting to pass a
# large message on, nothing was sent any more, and the link was given up. What watches sockets also writes to them.
# Two wake each other for each message. What moves or serves has two all the same: one may wait while a stop comes.
LEAF_RUNTIMES = tuple(
    f"(rx: (worker_threads: {receivers}), acc: (handover: app), tx: (handover: app), net: (handover: app))"
    for receivers in (1, 2)
)
ROUTER_RUNTIME = "(tx: (handover: acc))"
RUNTIME_VARIABLE = "ZENOH_RUNTIME"

if os.environ.get(RUNTIME_VARIABLE) not in LEAF_RUNTIMES:
    os.environ.pop(RUNTIME_VARIABLE, None)  # a shell's own wish, which the library may not understand, and then panics

import zenoh
from msgspec import Struct

from lbr.bus import access
from lbr.bus.access import Credentials, Limits, Rights
from lbr.bus.wire import plain
from lbr.errors import BusError

Session = zenoh.Session

PANIC = "PanicException"
"""The error of the bus library where it may start no threads; its class cannot be imported."""
FORKED = (
    "this process was forked from one that uses the bus, and has none of that library's threads: "
    "start it by 'spawn' of multiprocessing, or as a program of its own"
)
"""A call of the library there, or a session opened there, would wait for ever, also after all sessions were closed."""
_opened_by: set[int] = set()
"""This process, once it has opened a session; in one that was forked since, the one that it was forked from."""

LINK_LEASE_MS = 400
"""The lease of links over a network, which may be cut; a frozen process was lost after 0.3 to 0.8 s."""
LOCAL_LEASE_MS = 10_000
"""The lease of links by a socket of this machine, where the kernel reports at once that a process has ended. On a busy
machine a client of low rank was silent for 0.4 s, lost its link, and with it the answers under way."""
HELD_MS = 3_600_000
"""The lease of a local router's links: if both ends give each other up, it does not learn again who answers what."""
MAX_MESSAGE_BYTES = 1 << 20
DEAF_AWAY_MS, DEAF_HERE_MS = 200, 400
"""A client that takes nothing is cut off then, because all others wait for it; on this machine it may be held up."""
ACCEPT_MS, MOST_PENDING = 3000, 500
"""Connections that have greeted by TLS and say no more keep others out no longer than this, and only when there are
many. The library answers earlier failures with a pause of 0.1 s, which nothing can set."""
MOST_SESSIONS = 1000
FILES_A_SESSION, FILES_A_PENDING = 4, 16
"""A router holds no more than its share of the files that its process may open. With hundreds of connections to two
routers, the executive can still answer, start and write. The library accepts in one thread and refuses in another, and
nothing bounds the queue between them. On a busy machine new connections may stay open for some milliseconds."""


class Tls(Struct, frozen=True, kw_only=True):
    """Files of a router that listens on TLS: its private key and its certificate, both PEM."""

    private_key: str
    certificate: str


class Router(Struct, frozen=True, kw_only=True):
    """A router to open: where it listens, whom it knows, what they may do, and the router it hangs on.

    Without `users` it asks for no password. `links` are the rights of routers it connects to, by their `id`. Its
    questions on the keys `never_waiting` are dropped where they cannot go on at once, and so are the answers; with
    `urgent_waits` except those at the highest priority. Without `lease_ms` the endpoints decide, as for a client.
    """

    listen: tuple[str, ...]
    robot: str = ""
    users: dict[str, str] = {}
    rights: dict[str, Rights] = {}
    links: dict[str, Rights] = {}
    connect: tuple[str, ...] = ()
    credentials: Credentials | None = None
    id: str = ""
    tls: Tls | None = None
    limits: Limits | None = None
    never_waiting: tuple[str, ...] = ()
    urgent_waits: bool = False
    lease_ms: int | None = None


def open_router(router: Router) -> Session:
    """Open a router; raise BusError if an endpoint is taken, or the router it hangs on does not answer."""
    os.environ[RUNTIME_VARIABLE] = ROUTER_RUNTIME  # read when a process opens its first session
    with access.Dictionary(router.users) as dictionary:
        password = {"dictionary_file": dictionary.path} if router.users else {}
        return _open(router_settings(router, password), f"cannot listen on {', '.join(router.listen)}")


def router_settings(router: Router, password: dict[str, str] | None = None) -> dict[str, Any]:
    """Return the configuration of a router in Zenoh's own words; `password` names the file of its users' passwords."""
    lease_ms = HELD_MS if all(one.startswith("unixsock-stream/") for one in router.listen) else LINK_LEASE_MS
    settings = _common(router.credentials, password, lease_ms=router.lease_ms or lease_ms) | {
        "mode": "router",
        "listen": {"endpoints": list(router.listen), "exit_on_failure": True},
    }
    block = {"wait_before_close": 1000 * (DEAF_HERE_MS if router.limits is None else DEAF_AWAY_MS)}
    settings["transport"]["link"]["tx"]["queue"] = {"congestion_control": {"block": block}}
    if router.id:
        settings["id"] = router.id
    if router.connect:
        settings["connect"] = _connect(router.connect, 2.0)
    if router.rights or router.links:
        settings["access_control"] = access.control(router.robot, router.rights, router.links)
    files, _ = resource.getrlimit(resource.RLIMIT_NOFILE)
    share = files if files != resource.RLIM_INFINITY else MOST_SESSIONS * FILES_A_SESSION
    settings["transport"]["unicast"] = {
        "accept_timeout": ACCEPT_MS,
        "accept_pending": min(MOST_PENDING, share // FILES_A_PENDING),
        "max_sessions": min(MOST_SESSIONS, share // FILES_A_SESSION),
    }
    if router.never_waiting:
        settings |= access.never_waiting(router.never_waiting, urgent_waits=router.urgent_waits)
    if router.limits is not None:
        settings |= access.limits(router.limits)
        settings["transport"]["unicast"]["max_sessions"] = router.limits.sessions
    if router.tls is not None:
        settings["transport"]["link"]["tls"] = {
            "listen_private_key": router.tls.private_key,
            "listen_certificate": router.tls.certificate,
        }
    return settings


def client_settings(
    connect: Sequence[str],
    credentials: Credentials | None = None,
    *,
    certificate: str = "",
    timeout_s: float = 2.0,
    lease_ms: int | None = None,
) -> dict[str, Any]:
    """Return the configuration of a session to the router at one of `connect`, in Zenoh's own words.

    `certificate` is the PEM of the only one that the router may show; its host name is then not looked at.
    Without `lease_ms` the endpoints decide how long the link may be silent.
    """
    local = all(endpoint.startswith("unixsock-stream/") for endpoint in connect)
    lease_ms = lease_ms or (LOCAL_LEASE_MS if local else LINK_LEASE_MS)
    settings = _common(credentials, lease_ms=lease_ms) | {"mode": "client", "connect": _connect(connect, timeout_s)}
    if certificate:
        settings["transport"]["link"]["tls"] = {
            "root_ca_certificate_base64": base64.b64encode(certificate.encode()).decode(),
            "verify_name_on_connect": False,
        }
    return settings


def open_client(
    connect: Sequence[str],
    credentials: Credentials | None = None,
    *,
    certificate: str = "",
    timeout_s: float = 2.0,
    lease_ms: int | None = None,
) -> Session:
    """Open a session to the router at one of `connect`; raise BusError if none lets it in within `timeout_s`."""
    settings = client_settings(connect, credentials, certificate=certificate, timeout_s=timeout_s, lease_ms=lease_ms)
    return _open(settings, f"cannot reach a robot at {', '.join(connect)}")


def _common(
    credentials: Credentials | None = None, password: dict[str, str] | None = None, *, lease_ms: int = LINK_LEASE_MS
) -> dict[str, Any]:
    proof = {"user": credentials.user, "password": credentials.password} if credentials is not None else {}
    auth = {**proof, **(password or {})}
    return {
        "scouting": {"multicast": {"enabled": False}, "gossip": {"enabled": False}, "delay": 0},
        "transport": {
            "link": {"tx": {"lease": lease_ms, "keep_alive": 4}, "rx": {"max_message_size": MAX_MESSAGE_BYTES}},
            "shared_memory": {"enabled": False},
            **({"auth": {"usrpwd": auth}} if auth else {}),
        },
        "timestamping": {"enabled": False},
        "adminspace": {"enabled": False},
        "queries_default_timeout": 2000,
    }


def _connect(endpoints: Sequence[str], timeout_s: float) -> dict[str, Any]:
    return {
        "endpoints": list(endpoints),
        "timeout_ms": int(timeout_s * 1000),
        "exit_on_failure": True,
        "retry": {"period_init_ms": 50, "period_max_ms": 300, "period_increase_factor": 2},
    }


def _open(settings: dict[str, object], subject: str) -> Session:
    if _opened_by - {os.getpid()}:
        raise BusError(FORKED)
    _opened_by.add(os.getpid())
    try:
        return zenoh.open(zenoh.Config.from_json5(json.dumps(settings)))
    except zenoh.ZError as err:
        raise BusError(f"{subject}: {plain(err)}") from err
    except BaseException as err:
        if type(err).__name__ != PANIC:
            raise
        raise BusError(f"{subject}: the bus library does not start ({err}); free memory, or raise 'ulimit -u'") from err


def leaf_environment(*, waits: bool = False) -> dict[str, str]:
    """Return this process's environment for a child that opens leaf sessions; `waits`: nothing of it is urgent."""
    return os.environ | {RUNTIME_VARIABLE: LEAF_RUNTIMES[0 if waits else 1]}
