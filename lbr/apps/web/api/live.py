"""`/api/live`: the newest messages of a page's streams, events, and the page's motion; on the server's thread."""

from collections import deque
from collections.abc import Iterator, Mapping
from contextlib import suppress
from math import isnan

import msgspec
from msgspec import UNSET
from starlette.types import Scope

from lbr.apps.http.turns import Turns
from lbr.apps.web.api.catalog import EVENT
from lbr.apps.web.api.feeds import KEPT_S, Feeds
from lbr.apps.web.api.holds import Hand, HoldNews
from lbr.apps.web.api.link_age import OLDEST_S, LinkAge, LinkNews
from lbr.apps.web.api.page_message import USUAL_HZ, PageMessage, Rubbish, Wanted, parse
from lbr.apps.web.api.requests import source_of
from lbr.apps.web.api.service import NO_BUS, Api
from lbr.apps.web.application import Gate
from lbr.apps.web.face import Client, Refused
from lbr.apps.web.routing import Path
from lbr.apps.web.sessions import Sessions
from lbr.apps.web.viewing import Viewer, Viewing, shown_token

MOST_NEWS = 16
PULSE_S = 0.2
"""The longest pause between frames. A page quotes a frame's time, and one older than `OLDEST_S` would begin nothing."""
HELD_PULSE_S = 0.05
"""The longest pause between frames while the page's hand is on."""
LINK_S = 0.5
"""The pause between reports of the link's age; a change of speed is reported at once."""
_encode = msgspec.json.Encoder().encode


class Live(Viewing):
    """The sockets of pages. `page` is the build of the served page, sent first: a page of another build moves
    nothing."""

    path = Path("/api/live")
    protocols = ("lbr.live",)

    def __init__(self, api: Api, gate: Gate, viewers: Turns, sessions: Sessions, page: str = "") -> None:
        super().__init__(gate, viewers, sessions)
        self._api = api
        self._page = page

    async def client(self, scope: Scope, headers: Mapping[str, str]) -> Client:
        """Return the client, which may be the robot's owner; raise Refused."""
        return await self._gate.client(scope, headers, shown_token(scope), owner=True)

    def viewer(self, scope: Scope, client: Client) -> Viewer:
        """Return the viewer; raise Refused."""
        del scope
        if self._api.feeds is None:
            raise Refused(503, NO_BUS, code="not_possible")
        return _PageViewer(self._api, self._api.feeds, client, self._page)


class _PageViewer(Viewer):
    """A page: its streams, the messages sent to it, and its hand."""

    messages_hz, messages_at_once = 100.0, 200.0  # a page sends 25 a second, with a mouse 60; a network delivers late
    too_much = "too many messages"

    def __init__(self, api: Api, feeds: Feeds, client: Client, page: str) -> None:
        super().__init__(1.0 / USUAL_HZ)
        self._api = api
        self._feeds = feeds
        self._asked: tuple[str, ...] = ()
        self._wanted: tuple[str, ...] = ()
        self._known: object = None
        self._sent: dict[str, int] = {}
        self._event = 0
        self._news: deque[bytes] = deque([b'"page":' + _encode(page)] if page else (), maxlen=MOST_NEWS)
        self._frame_s = 0.0
        self._hand = Hand(source_of(client), api.may(client), self._tell_from_loop)
        self._has_hand = False
        self._age = LinkAge(PULSE_S)
        self._link: LinkNews | None = None
        self._link_s = 0.0

    def frames(self) -> Iterator[str]:
        """Yield the messages that are due, as one."""
        now = self._api.now()
        if self._known is not self._api.known:
            self._want()
        parts = [part for part in (self._streams(now), self._events()) if part]
        if self._news:
            parts.append(self._news.popleft())
        if not parts and now - self._frame_s < (HELD_PULSE_S if self._hand.wish.wanted is not None else PULSE_S):
            return
        self._frame_s = now
        yield b"".join((b'{"t":%d' % int(now * 1000), *(b"," + part for part in parts), b"}")).decode()

    async def rest(self, seconds: float) -> None:
        """Wait that long, or until there is news."""
        if not self._news:
            await super().rest(seconds)
        self._woken.clear()

    def leave(self) -> None:
        """Release the hand for good, and leave all streams."""
        self._hand.release(for_good=True)
        if self._has_hand:
            self._api.wake()
        self._feeds.leave(self)
        self._loop.call_later(KEPT_S + 0.1, self._feeds.tidy)

    def receive(self, message: str | bytes) -> None:
        """Handle a message of the page."""
        try:
            wanted = parse(message.encode("utf-8", "surrogatepass") if isinstance(message, str) else message)
        except Rubbish as err:
            self._hand.release()  # an unreadable message may have been a release
            self._api.wake()
            self._tell(b'"error":' + _encode({"code": "malformed", "reason": str(err)}))
            return
        if wanted.rate_hz is not UNSET:
            self.period_s = 1.0 / wanted.rate_hz
        if wanted.hear is not UNSET:
            self._asked = wanted.hear
            self._want()
        self._move(wanted)

    def _move(self, message: PageMessage) -> None:
        now = self._api.now()
        late = message.t is not UNSET and not 0.0 <= now - message.t / 1000 <= OLDEST_S
        if message.t is not UNSET and (message.hold is not UNSET or message.keep is not UNSET):
            self._age.note(now - message.t / 1000, now)
        if message.release is True:
            self._hand.release()
            self._age, self._link = LinkAge(PULSE_S), None
        elif message.hold is not UNSET and late:
            self._hand.release()
            text = f"the command arrived more than {OLDEST_S:g} s late: let go and try again"
            self._tell(_hold(HoldNews(n=message.hold.n, holds=False, code="late", reason=text)))
        elif message.hold is not UNSET:
            self._hold(message.hold, now)
        elif message.keep is not UNSET and not late:
            self._hand.keep(message.keep, now, self._age.share)
            self._tell_link(now)
            return
        else:
            return
        self._api.wake()

    def _hold(self, wanted: Wanted, now: float) -> None:
        self._hand.hold(wanted, now, self._age.share)
        self._tell_link(now)
        if not self._has_hand:
            self._has_hand = True
            self._api.holds.add(self._hand)

    def _tell_link(self, now: float) -> None:
        """Send the page the age of its link, and the share of speed that it allows."""
        if isnan(self._age.age_s):
            return
        news, before = self._age.news, self._link
        if before is None or news.speed != before.speed or (news != before and now - self._link_s >= LINK_S):
            self._link, self._link_s = news, now
            self._tell(b'"link":' + _encode(news))

    def _want(self) -> None:
        """Subscribe to the requested streams that exist."""
        known = self._known = self._api.known
        self._wanted = known.published(self._asked) if known is not None else ()
        if EVENT in self._wanted and EVENT not in self._sent:
            self._sent[EVENT] = self._event = self._feeds.last_event
        self._feeds.want(self, self._wanted)

    def _streams(self, now: float) -> bytes:
        """Return the newest message of each stream with news since the last frame."""
        parts: list[bytes] = []
        for name in self._wanted:
            sample = self._feeds.newest(name) if name != EVENT else None
            if sample is not None and sample.number != self._sent.get(name):
                self._sent[name] = sample.number
                age_ms = max(0, int((now - sample.sent_s) * 1000))
                parts.append(b'"%s":{"age_ms":%d,"message":%s}' % (name.encode(), age_ms, sample.text))
        return b'"streams":{%s}' % b",".join(parts) if parts else b""

    def _events(self) -> bytes:
        events = self._feeds.events(self._event) if EVENT in self._wanted else ()
        if not events:
            return b""
        self._event = events[-1].number
        return b'"events":[%s]' % b",".join(one.text for one in events)

    def _tell(self, news: bytes) -> None:
        self._news.append(news)
        self._woken.set()

    def _tell_from_loop(self, news: HoldNews) -> None:
        """Queue news for the page; from the capability's loop."""
        with suppress(RuntimeError):  # the server, and with it the page, has ended
            self._loop.call_soon_threadsafe(self._tell, _hold(news))


def _hold(news: HoldNews) -> bytes:
    return b'"hold":' + _encode(news)
