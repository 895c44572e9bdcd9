"""The words `phone`, `pair`, `open` and `close`: who has access through the server for people, and from where."""

import contextlib
import ipaddress
import time
from collections.abc import Callable, Iterator
from dataclasses import KW_ONLY, dataclass
from typing import get_args

from msgspec.structs import asdict, replace

from lbr import qr
from lbr.database.rows import CapabilityRow
from lbr.errors import InputError
from lbr.executive.planning import credentials
from lbr.executive.service.pairing import GOOD_FOR_S, WRONG_TRIES
from lbr.executive.service.robot import Robot
from lbr.messages.schema import JsonObject
from lbr.messages.system import ConsoleResult, Role

EVERYWHERE, HERE = "0.0.0.0", "127.0.0.1"  # noqa: S104 - what the word `open` is for
ADDRESS_S = 1.0
AGAIN_S = 10.0
"""A server that listens elsewhere is a new process, which takes some seconds to start on a busy machine."""
LOOK_S = 0.2
OPERATE: Role = "operate"
HOLD = "Hold the phone's camera at the picture, or type the address and the six digits there:"


@dataclass(eq=False)
class LettingIn:
    """Answers the words. `address(name, timeout_s)` asks a server for its address; None if it does not answer."""

    robot: Robot
    address: Callable[[str, float], JsonObject | None]
    _: KW_ONLY
    clock: Callable[[], float] = time.monotonic
    pause: Callable[[float], None] = time.sleep

    def page(self) -> str:
        """Return the address of the server; raise InputError with the reason if it has no address."""
        name = self._server().name
        place = self._serving(name)
        if place is None:
            raise InputError(f"'{name}' does not serve now", "unreachable")
        return _where(place)

    def phone(self, requester: str) -> ConsoleResult:
        """Open the server as `open` does, unless it is open, and draw a code as `pair` does."""
        name = self._server().name
        if not self._opened(name, requester):
            return self.pair(OPERATE, requester)
        if self._settled(name, is_open=True) is None:
            text = f"'{name}' starts again, to be open to your network; type 'phone' again in a moment"
            return ConsoleResult(code=1, text=text, reason_code="unreachable")
        result = self.pair(OPERATE, requester)
        return replace(result, text=f"'{name}' is open to your network now; 'close' takes it back.\n{result.text}")

    def pair(self, role: str, requester: str) -> ConsoleResult:
        """Draw a code, and return it with everything that a person needs to type or scan it."""
        if role not in get_args(Role):
            raise InputError(f"'{role[:40]}' is not a role that a phone may have: say {', '.join(get_args(Role))}")
        name = self._server().name
        place = self._serving(name)
        if place is None:
            text = f"'{name}' does not serve now, so that no phone could show a code; 'status' shows the reason"
            return ConsoleResult(code=1, text=text, reason_code="unreachable")
        code = self.robot.pair(role, requester)  # type: ignore[arg-type]
        url, is_open, tls = str(place.get("url", "")), bool(place.get("open")), bool(place.get("tls"))
        way = f"{url}#pair={code.digits}" if url else ""
        print_of = credentials.fingerprint_shown() if tls else ""
        data = {
            "digits": code.digits,
            "role": role,
            "good_for_s": GOOD_FOR_S,
            "url": way,
            "local": place.get("local", ""),
            "open": is_open,
            "svg": _svg(way) if is_open and way else "",
            "fingerprint": print_of,
        }
        drawn, minutes = _drawn(way) if is_open and url else "", GOOD_FOR_S / 60
        lines = [
            *([HOLD] if drawn else ()),
            f"{code.digits[:3]} {code.digits[3:]}   at {_where(place)}",
            f"The code is good for {minutes:g} minutes and one device, which gets a token with the role '{role}'.",
            f"{WRONG_TRIES} wrong tries end it, as does another code.",
            *_honest(is_open=is_open, tls=tls, own=tls and credentials.is_own_shown(), fingerprint=print_of),
            *([drawn] if drawn else ()),  # the last line, so that a terminal of 24 lines shows it whole
        ]
        return ConsoleResult(code=0, text="\n".join(lines), data=data)

    def open(self, requester: str) -> ConsoleResult:
        """Make the server listen to the network, unless it does; return the consequences and its address."""
        name = self._server().name
        if self._opened(name, requester):
            text = f"'{name}' is open to your network now"
        else:
            text = f"'{name}' is open already: it listens at {self._host(name)}"
        place = self._settled(name, is_open=True)
        cost = "Every machine that reaches this one can ask it, over Wi-Fi and cable. 'phone' lets a phone in"
        told = str(place.get("reason", "")) if place is not None else f"'{name}' starts; 'qr' shows the address"
        return ConsoleResult(code=0, text=f"{text}. {cost}; 'close' takes it back.\n{told}", data=_place_data(place))

    def close(self, requester: str) -> ConsoleResult:
        """Make the server listen to this machine only, unless it does."""
        row = self._server()
        if _is_local(self._host(row.name)):
            text = f"'{row.name}' is closed already: only this machine reaches it"
            return ConsoleResult(code=0, text=text)
        self.robot.listen_at(row.name, HERE, requester)
        self._settled(row.name, is_open=False)
        text = f"'{row.name}' is closed: only this machine reaches it"
        return ConsoleResult(code=0, text=f"{text}. Tokens stay; 'lbr token revoke NAME' takes one back")

    def _server(self) -> CapabilityRow:
        """Return the row of the server for people: of several, one that runs, or is named like its kind."""
        plan = self.robot.plan
        rows = [row for row in plan.rows.capabilities if row.name in plan.kinds and plan.kinds[row.name].rights.pairs]
        server = min(rows, key=lambda row: (row.name not in plan.units, row.name != row.kind, row.name), default=None)
        if server is None:
            raise InputError("this robot has no server for people", "not_possible")
        if server.name not in plan.units:
            why = "its row is disabled" if not server.enabled else "the profile leaves it out"
            raise InputError(f"'{server.name}' does not run: {why}", "unreachable")
        return server

    def _opened(self, name: str, requester: str) -> bool:
        """Make a server listen to the network; return False if it does already."""
        if not _is_local(self._host(name)):
            return False
        self.robot.listen_at(name, EVERYWHERE, requester)
        return True

    def _host(self, name: str) -> str:
        """Return the address at which a server's row makes it listen."""
        plan = self.robot.plan
        return str(asdict(plan.kinds[name].parse(bytes(plan.units[name].config.settings)))["host"])

    def _serving(self, name: str) -> dict[str, object] | None:
        """Return where a server listens; None if it does not serve."""
        place = self.address(name, ADDRESS_S)
        return place if place is not None and place.get("accepted") else None

    def _settled(self, name: str, *, is_open: bool) -> dict[str, object] | None:
        """Wait until a server listens as its row now requires, and return where; None if that takes long."""
        end = self.clock() + AGAIN_S
        while self.clock() < end:
            place = self._serving(name)
            if place is not None and bool(place.get("open")) is is_open:
                return place
            self.pause(LOOK_S)
        return None


def _honest(*, is_open: bool, tls: bool, own: bool, fingerprint: str) -> Iterator[str]:
    if not is_open:
        yield "Only this machine reaches that address: 'phone' opens it to your network and shows a code to scan."
    if tls:
        if own:
            known = "A browser that does not know your certificate (credentials/web.crt) warns."
            yield f"{known} Its SHA-256 fingerprint is"
        else:
            warns = "The phone's browser warns once, because the robot made its certificate itself."
            yield f"{warns} Go on if the SHA-256 fingerprint there is this one:"
        yield fingerprint
    elif is_open:
        yield "Nothing is encrypted ('clear_text' of its row): a machine in between reads the code and the token."


def _where(place: dict[str, object]) -> str:
    """Return a server's address, by number and by name."""
    url, local = str(place.get("url", "")), str(place.get("local", ""))
    if not url:
        return "the address of this machine, which is in no network now"
    return f"{url} or {local}" if local else url


def _drawn(url: str) -> str:
    """Return a QR code for a terminal; empty if its library is missing here: the server may have its own."""
    with contextlib.suppress(ImportError):
        return qr.characters(url)
    return ""


def _svg(url: str) -> str:
    """Return the same code for a page."""
    with contextlib.suppress(ImportError):
        return qr.drawing(url).decode()
    return ""


def _place_data(place: dict[str, object] | None) -> dict[str, object]:
    return {"url": place.get("url", ""), "open": place.get("open"), "tls": place.get("tls")} if place else {}


def _is_local(host: str) -> bool:
    with contextlib.suppress(ValueError):
        return ipaddress.ip_address(host).is_loopback
    return host == "localhost"
