"""Zenoh sessions: one router in the executive, clients everywhere else; no scouting, nothing beyond what is named."""

import json
import os
import re
from collections.abc import Sequence
from typing import Any

# One runtime thread is enough for a leaf process and saves a third of its latency and CPU; a router collapses with it.
LEAF_RUNTIME = "(rx: (handover: app), acc: (handover: app), tx: (handover: app), net: (handover: app))"
RUNTIME_VARIABLE = "ZENOH_RUNTIME"

import zenoh  # noqa: E402 - the runtime reads its environment when the library loads

from lbr.errors import BusError  # noqa: E402

Session = zenoh.Session

LINK_LEASE_MS = 400
MAX_MESSAGE_BYTES = 1 << 20


def _common() -> dict[str, Any]:
    return {
        "scouting": {"multicast": {"enabled": False}, "gossip": {"enabled": False}, "delay": 0},
        "transport": {
            "link": {"tx": {"lease": LINK_LEASE_MS, "keep_alive": 4}, "rx": {"max_message_size": MAX_MESSAGE_BYTES}},
            "shared_memory": {"enabled": False},
        },
        "timestamping": {"enabled": False},
        "adminspace": {"enabled": False},
        "queries_default_timeout": 2000,
    }


def _open(settings: dict[str, Any], what: str) -> Session:
    try:
        return zenoh.open(zenoh.Config.from_json5(json.dumps(settings)))
    except zenoh.ZError as err:
        raise BusError(f"{what}: {_plain(err)}") from err


def _plain(err: Exception) -> str:
    """Leave out where in the library's source an error was raised."""
    return re.sub(r" at /\S+", "", str(err)).rstrip(". !")


def open_router(listen: Sequence[str]) -> Session:
    """Open the router that everybody meets at, listening on `listen`; raise BusError if an endpoint is taken."""
    settings = _common() | {"mode": "router", "listen": {"endpoints": list(listen), "exit_on_failure": True}}
    return _open(settings, f"cannot listen on {', '.join(listen)}")


def open_client(connect: Sequence[str], *, timeout_s: float = 2.0) -> Session:
    """Open a session to the router at one of `connect`; raise BusError if none answers within `timeout_s`."""
    settings = _common() | {
        "mode": "client",
        "connect": {
            "endpoints": list(connect),
            "timeout_ms": int(timeout_s * 1000),
            "exit_on_failure": True,
            "retry": {"period_init_ms": 50, "period_max_ms": 300, "period_increase_factor": 2},
        },
    }
    return _open(settings, f"cannot reach a robot at {', '.join(connect)}")


def leaf_environment() -> dict[str, str]:
    """Return this process's environment for a child that opens leaf sessions."""
    return os.environ | {RUNTIME_VARIABLE: LEAF_RUNTIME}
