"""The rights on a router: its users, and what each may send and receive.

Zenoh enforces them, and reports no refusal: it drops a message that is not allowed where it arrives.
"""

import os
from collections.abc import Mapping
from typing import Any, Self

from msgspec import Struct

from lbr.bus import keys

TOOLS = "@tools"
"""The user of `lbr`'s own commands on the robot's machine."""


class Credentials(Struct, frozen=True, kw_only=True):
    """A user of a router and the password that proves it."""

    user: str
    password: str


class Rights(Struct, frozen=True, kw_only=True):
    """The rights of a user, each as key expressions; all other messages are dropped.

    `put`: to publish. `ask`: to query. `serve`: to answer queries. `hear`: to subscribe and receive. `alive`: to show
    presence. `watch`: to see it. `never_put` removes part of `put`, and `never_hear` part of the messages that `hear`
    permits. `trusted` permits everything else in the key space.
    """

    put: tuple[str, ...] = ()
    never_put: tuple[str, ...] = ()
    ask: tuple[str, ...] = ()
    serve: tuple[str, ...] = ()
    hear: tuple[str, ...] = ()
    never_hear: tuple[str, ...] = ()
    alive: tuple[str, ...] = ()
    watch: tuple[str, ...] = ()
    trusted: bool = False

    def and_of(self, more: "Rights") -> "Rights":
        """Return the rights of both together."""
        return Rights(
            put=_either(self.put, more.put),
            never_put=tuple(key for key in self.never_put if key in more.never_put),
            ask=_either(self.ask, more.ask),
            serve=_either(self.serve, more.serve),
            hear=_either(self.hear, more.hear),
            never_hear=tuple(key for key in self.never_hear if key in more.never_hear),
            alive=_either(self.alive, more.alive),
            watch=_either(self.watch, more.watch),
            trusted=self.trusted or more.trusted,
        )


def _either(some: tuple[str, ...], others: tuple[str, ...]) -> tuple[str, ...]:
    return tuple(dict.fromkeys((*some, *others)))


class Limits(Struct, frozen=True, kw_only=True):
    """The limits of a router for each link of `protocols`: the size of a message, and the rate on a key.

    Puts beyond `puts_hz` are dropped where they arrive. At most `sessions` are open at the same time.
    """

    protocols: tuple[str, ...]
    bytes: int
    keys: tuple[str, ...]
    puts_hz: dict[str, float] = {}
    sessions: int = 64


_IN: dict[str, tuple[str, ...]] = {
    "put": ("put", "delete"),
    "ask": ("query",),
    "serve": ("declare_queryable", "reply"),
    "hear": ("declare_subscriber",),
    "alive": ("liveliness_token",),
    "watch": ("liveliness_query", "declare_liveliness_subscriber"),
}
_EVERYTHING = tuple(message for messages in _IN.values() for message in messages)
_GIVEN = ("put", "delete", "reply", "liveliness_token")
_ANNOUNCED = tuple(message for message in _EVERYTHING if message not in _GIVEN)


_NOT_URGENT = ("interactive_high", "interactive_low", "data_high", "data", "data_low", "background")
"""Zenoh's priorities except the highest, which our own clients use for queries."""


def everything(robot: str) -> tuple[str, ...]:
    """Return the whole key space; `**` does not match chunks that begin with `@`."""
    system = (
        "console",
        "estop",
        "status",
        "event",
        "alive",
        "schema",
        "host",
        "edit",
        "pair",
        "manage",
        "router",
        "taped",
    )
    return (f"{robot}/**", *(f"{robot}/@{name}/**" for name in system), keys.ANY_STATUS)


def control(robot: str, users: Mapping[str, Rights], links: Mapping[str, Rights] | None = None) -> dict[str, Any]:
    """Return Zenoh's access control: deny by default, `users` by name and `links` by the session id of a router.

    Links are unix sockets: a client on another machine that knows such an id gains nothing by it.
    """
    rules: list[dict[str, Any]] = []
    subjects: list[dict[str, Any]] = []
    policies: list[dict[str, Any]] = []
    named = [(f"user {name}", {"usernames": [name]}, rights) for name, rights in users.items()]
    named += [
        (f"link {zid}", {"zids": [zid], "link_protocols": ["unixsock-stream"]}, rights)
        for zid, rights in (links or {}).items()
    ]
    for label, subject, rights in named:
        own = list(_rules(label, rights, everything(robot)))
        rules += own
        subjects.append({"id": label, **subject})
        policies.append({"rules": [rule["id"] for rule in own], "subjects": [label]})
    return {
        "enabled": True,
        "default_permission": "deny",
        "rules": rules,
        "subjects": subjects,
        "policies": policies,
    }


def _rules(label: str, rights: Rights, all_keys: tuple[str, ...]) -> list[dict[str, Any]]:
    rules: list[dict[str, Any]] = []
    if rights.never_put:
        rules.append(_rule(f"{label}: never", ("ingress",), _IN["put"], rights.never_put, permission="deny"))
    if rights.never_hear:
        rules.append(_rule(f"{label}: unheard", ("egress",), _IN["put"], rights.never_hear, permission="deny"))
    if rights.trusted:
        return [*rules, _rule(f"{label}: all", ("ingress", "egress"), _EVERYTHING, all_keys)]
    rules += [
        _rule(f"{label}: {what}", ("ingress",), messages, allowed)
        for what, messages in _IN.items()
        if (allowed := getattr(rights, what))
    ]
    given = tuple(dict.fromkeys((*rights.hear, *rights.ask, *rights.watch)))
    if given:
        rules.append(_rule(f"{label}: given", ("egress",), _GIVEN, given))
    return [*rules, _rule(f"{label}: told", ("egress",), _ANNOUNCED, all_keys)]


def _rule(
    name: str, flows: tuple[str, ...], messages: tuple[str, ...], key_exprs: tuple[str, ...], permission: str = "allow"
) -> dict[str, Any]:
    return {
        "id": name,
        "permission": permission,
        "flows": list(flows),
        "messages": list(messages),
        "key_exprs": list(key_exprs),
    }


def limits(bounds: Limits) -> dict[str, Any]:
    """Return Zenoh's filters for incoming messages over a kind of link."""
    common = {"link_protocols": list(bounds.protocols), "flows": ["ingress"]}
    rules = [{"key_expr": key, "freq": hz} for key, hz in bounds.puts_hz.items()]
    return {
        "low_pass_filter": [
            {
                "id": "size",
                **common,
                "messages": ["put", "delete", "query", "reply"],
                "key_exprs": list(bounds.keys),
                "size_limit": bounds.bytes,
            }
        ],
        "downsampling": [{"id": "rate", **common, "messages": ["put", "delete"], "rules": rules}],
    }


def never_waiting(key_exprs: tuple[str, ...], *, urgent_waits: bool = False) -> dict[str, Any]:
    """Return Zenoh's rules that make queries on these keys droppable: no process waits for a client that asks and does
    not read.

    An answer inherits this from its query, and an undroppable one blocks its sender for seconds. With `urgent_waits`,
    queries of the highest priority are never dropped: our own commands and stops have that.
    """
    rule = {
        "messages": ["query"],
        "key_exprs": list(key_exprs),
        "flows": ["egress"],
        "overwrite": {"congestion_control": "drop"},
    }
    if not urgent_waits:
        return {"qos": {"network": [{"id": "never waiting", **rule}]}}
    rules = [{"id": f"never waiting {name}", "qos": {"priority": name}, **rule} for name in _NOT_URGENT]
    return {"qos": {"network": rules}}


class Dictionary:
    """Zenoh's file of users and passwords, in memory, and gone once the router has read it."""

    def __init__(self, users: Mapping[str, str]) -> None:
        self._fd = os.memfd_create("users", os.MFD_CLOEXEC)
        os.write(self._fd, "".join(f"{name}:{password}\n" for name, password in users.items()).encode())
        self.path = f"/proc/self/fd/{self._fd}"

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_exc: object) -> None:
        os.close(self._fd)
