"""The rules of calls: callers, viewers, displays and their time limits, without clock, bus or media.

`orders` are for the media, `news` are events; the capability takes both.
"""

from collections.abc import Callable
from dataclasses import dataclass
from math import inf
from secrets import token_urlsafe

from lbr.apps.call.kind import CallSettings
from lbr.apps.call.messages import CallPhase, Purpose, RingCommand, RingReply
from lbr.messages.codes import Reason
from lbr.messages.system import Role, role_missing

SILENT_S = 8.0
"""A page reports every second that it is open. A phone that is put down, or a poor network, may miss some reports."""
CONNECT_S = 15.0
"""The time to connect. Two machines of one network need less than one second; without a route the try ends then."""
MOST_DISPLAYS = 2
DISPLAY_ROLE: Role = "operate"
ENDED_KEPT = 16


@dataclass(slots=True)
class Guest:
    """A page that rang: its purpose, its name, and the phase of its call."""

    id: str
    purpose: Purpose
    name: str
    offer: str
    heard_s: float
    until_s: float
    phase: CallPhase
    answer: str = ""


@dataclass(frozen=True, slots=True)
class Connect:
    """Make a connection for a guest."""

    id: str
    purpose: Purpose
    offer: str


@dataclass(frozen=True, slots=True)
class Close:
    """Close a guest's connection, if there is one."""

    id: str


@dataclass(frozen=True, slots=True)
class News:
    """An event to publish."""

    kind: str
    text: str
    level: str = "info"
    code: str = ""


class Desk:
    """One caller at a time, some viewers, and the robot's own displays."""

    def __init__(self, settings: CallSettings, make_id: Callable[[], str] = lambda: token_urlsafe(12)) -> None:
        self.orders: list[Connect | Close] = []
        self.news: list[News] = []
        self.calls = 0
        self.lacks = ""
        """Why no call is possible; empty if calls are."""
        self.last = Reason("idle", "")
        self._settings = settings
        self._make_id = make_id
        self._guests: dict[str, Guest] = {}
        self._ended: dict[str, Reason] = {}

    @property
    def caller(self) -> Guest | None:
        """The caller."""
        return next((one for one in self._guests.values() if one.purpose == "talk"), None)

    @property
    def phase(self) -> CallPhase:
        """The state of the call."""
        return self.caller.phase if self.caller is not None else "idle"

    @property
    def pictured(self) -> int:
        """The number of pages that get a picture by WebRTC, or will once they are answered."""
        return sum(one.purpose != "display" for one in self._guests.values())

    @property
    def displays(self) -> int:
        """The number of the robot's displays that show the caller."""
        return sum(one.purpose == "display" and one.phase == "talking" for one in self._guests.values())

    @property
    def any(self) -> bool:
        """Return whether there is any guest."""
        return bool(self._guests)

    def ring(self, command: RingCommand, now: float) -> RingReply:
        """Admit a page, or refuse it with the reason."""
        if (why := self._why_not(command)) is not None:
            if why.code != "malformed":
                self.news.append(News("call_refused", f"{command.by} ({command.purpose}): {why}", "info", why.code))
            return RingReply(accepted=False, reason=str(why), code=why.code)
        waits = command.purpose == "talk" and self._settings.answer == "ask"
        guest = Guest(
            id=self._make_id(),
            purpose=command.purpose,
            name=command.by or "a page",
            offer=command.offer,
            heard_s=now,
            until_s=now + (self._settings.ring_s if waits else CONNECT_S),
            phase="ringing" if waits else "connecting",
        )
        self._guests[guest.id] = guest
        if waits:
            said = "/call/answer or /call/decline"
            self.news.append(News("call_rings", f"{guest.name} calls: {said}", "warning"))
        else:
            if guest.purpose == "talk":
                self.news.append(News("call_answered", f"{guest.name} calls, and is answered at once, by its setting"))
            self._connect(guest, now)
        return self._reply(guest)

    def keep(self, id: str, now: float, *, leave: bool = False) -> RingReply:
        """Note that a page is present, or leaves; return the state of its call."""
        guest = self._guests.get(id)
        if guest is None and (why := self._ended.get(id)) is not None:
            return RingReply(accepted=True, id=id, phase="idle", reason=why.text, code=why.code)
        if guest is None:
            text = "there is no such call: the process that had it has started again since"
            return RingReply(accepted=False, reason=text, code="unknown_name")
        guest.heard_s = now
        if leave:
            self._end(guest, Reason("done", f"{guest.name} hung up"))
            return self.keep(id, now)
        return self._reply(guest)

    def answer(self, by: str, now: float) -> Reason | None:
        """Answer the call that rings; return why that is not possible."""
        guest = self.caller
        if guest is None or guest.phase != "ringing":
            return Reason("idle", "no call rings")
        self.news.append(News("call_answered", f"{by} answered the call of {guest.name}"))
        self._connect(guest, now)
        return None

    def finish(self, by: str, *, declined: bool) -> Reason | None:
        """End the call, or decline the one that rings; return why that is not possible."""
        guest = self.caller
        if guest is None:
            return Reason("idle", "there is no call")
        if declined and guest.phase != "ringing":
            return Reason("not_possible", "the call is answered already: /call/end ends it")
        self._end(guest, Reason("refused" if declined else "stopped", f"{by} {'declined' if declined else 'ended'} it"))
        return None

    def answered(self, id: str, answer: str) -> None:
        """Note the robot's part of a guest's connection."""
        if (guest := self._guests.get(id)) is not None:
            guest.answer = answer

    def connected(self, id: str) -> None:
        """Note that picture and sound are connected."""
        if (guest := self._guests.get(id)) is not None:
            guest.phase, guest.until_s = "talking", inf
            if guest.purpose != "display":
                self.news.append(News("call_connected", f"{guest.name} is connected ({_MEANS[guest.purpose]})"))

    def lost(self, id: str, why: Reason) -> None:
        """Note that a guest's connection failed, or ended."""
        if (guest := self._guests.get(id)) is not None:
            self._end(guest, why)

    def tick(self, now: float) -> None:
        """End silent guests, and calls that are late."""
        for guest in list(self._guests.values()):
            if now - guest.heard_s > SILENT_S:
                self._end(guest, Reason("holder_gone", f"the page of {guest.name} fell silent"))
            elif now > guest.until_s:
                self._end(guest, _LATE[guest.phase])

    def close(self, why: Reason) -> None:
        """End all calls, as the process ends."""
        for guest in list(self._guests.values()):
            self._end(guest, why)

    def _why_not(self, command: RingCommand) -> Reason | None:
        if self.lacks:
            return Reason("not_possible", self.lacks)
        needed = {"talk": self._settings.callers, "watch": self._settings.watchers, "display": DISPLAY_ROLE}
        if (missing := role_missing(needed[command.purpose], command.role)) is not None:
            return missing
        if (fault := fault_of(command.offer)) is not None:
            return fault
        return self._no_display() if command.purpose == "display" else self._no_picture(command.purpose)

    def _no_picture(self, purpose: Purpose) -> Reason | None:
        caller, most = self.caller, self._settings.most
        if purpose == "talk" and caller is not None:
            return Reason("busy", f"{caller.name} is in a call with the robot", holder=caller.name)
        if self.pictured >= most:
            return Reason("busy", f"{most} get the picture by WebRTC already, the most that the row allows")
        return None

    def _no_display(self) -> Reason | None:
        if self.caller is None:
            return Reason("idle", "there is no call to show")
        there = sum(one.purpose == "display" for one in self._guests.values())
        return Reason("busy", f"{there} displays show the caller already") if there >= MOST_DISPLAYS else None

    def _connect(self, guest: Guest, now: float) -> None:
        guest.phase, guest.until_s = "connecting", now + CONNECT_S
        if guest.purpose == "talk":
            self.calls += 1
        self.orders.append(Connect(guest.id, guest.purpose, guest.offer))

    def _end(self, guest: Guest, why: Reason) -> None:
        if self._guests.pop(guest.id, None) is None:
            return  # already ended with its caller
        self._ended[guest.id] = why
        while len(self._ended) > ENDED_KEPT:
            del self._ended[next(iter(self._ended))]
        self.orders.append(Close(guest.id))
        if guest.purpose != "display":
            self.news.append(News("call_ended", f"{guest.name} ({_MEANS[guest.purpose]}): {why}", code=why.code))
        if guest.purpose == "talk":
            self.last = why
            for one in [one for one in self._guests.values() if one.purpose == "display"]:
                self._end(one, Reason("done", "the call is over"))

    def _reply(self, guest: Guest) -> RingReply:
        return RingReply(accepted=True, id=guest.id, phase=guest.phase, answer=guest.answer)


_MEANS = {"talk": "a call", "watch": "watching", "display": "a display"}
_LATE: dict[CallPhase, Reason] = {
    "ringing": Reason("timeout", "the call was not answered"),
    "connecting": Reason("unreachable", "picture and sound found no way between browser and robot"),
}


def fault_of(offer: str) -> Reason | None:
    """Return why an offer cannot be answered, or None."""
    lines = offer.splitlines()
    if not lines or lines[0].strip() != "v=0":
        return Reason("malformed", "this is no offer of a browser: it must begin with 'v=0'")
    media = [line.split(" ", 1)[0] for line in lines if line.startswith("m=")]
    if not 1 <= len(media) <= MOST_MEDIA or "m=video" not in media or set(media) - {"m=video", "m=audio"}:
        return Reason("malformed", "an offer has a picture (m=video), at most one sound (m=audio) and nothing else")
    if len(set(media)) < len(media):
        return Reason("malformed", "an offer has one picture and one sound at most")
    if not any(line.startswith("a=rtpmap:") and VP8 in line.upper() for line in lines):
        return Reason("not_possible", "this browser offers no VP8, which is what the robot speaks")
    return None


def without_names(offer: str) -> str:
    """Return an offer without addresses that need a lookup, and without the mark that the list is complete.

    Browsers hide their addresses behind multicast names. They reach the robot by its own addresses, and are answered
    there.
    """
    kept = [line for line in offer.splitlines() if not _is_name(line) and line.strip() != "a=end-of-candidates"]
    return "\r\n".join(kept) + "\r\n"


def _is_name(line: str) -> bool:
    if not line.startswith("a=candidate:"):
        return False
    parts = line.split()
    return len(parts) < ADDRESS_AT + 1 or not set(parts[ADDRESS_AT]) <= set("0123456789abcdefABCDEF.:")


MOST_MEDIA, ADDRESS_AT, VP8 = 2, 4, "VP8/90000"
