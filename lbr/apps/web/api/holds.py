"""Motion that pages hold: one lease for each socket, renewed in the capability's loop only while its page asks for it.

    socket (server's thread)               loop
      hold, keep ──► Hand.wish ──────────►  Holds.step: begin · keep · release      LeaseClient ══ bus
      the page is silent, gone, rests ──►   release within a round
      Hand.news ◄───────────────────────    holds, refused, ended: the reason, and the holder

A page's message counts for `SILENT_S`, and for longer while its motion ends by itself (`patience`). A message that
quotes too old a time of the server does not count. It may come from a network that has just healed, and the hand may
have left the stick since.
"""

import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from math import nan

from msgspec import Struct
from msgspec.structs import replace

from lbr.apps.web.api.page_message import Wanted
from lbr.apps.web.api.patience import SILENT_S
from lbr.bus.stamp import Origin
from lbr.errors import BusError
from lbr.leases.client import LeaseClient, LeaseTarget, Transport
from lbr.messages.codes import Reason

AGAIN_S = 0.1
"""The pause before a new try while a stick is pushed against a refusal."""
ENDED_BY_OTHERS: frozenset[str] = frozenset(
    [
        "stopped",
        "stopped_since",
        "taken_over",
        "estop",
        "lapsed",
        "holder_gone",
        "dead_lease",
        "rest_first",
        "shutting_down",
        "unreachable",
        "failed",
    ]
)
"""The reasons after which a stick that is still pushed moves nothing: its page must release it first."""
REST = "release it first, and begin again"
RELEASED = "{} released it"
GONE = "{} is gone"
SILENT = "{} sent nothing for {:g} s"


class HoldNews(Struct, frozen=True, kw_only=True):
    """The state of a page's motion: whether it is held, the reason if not, and the holder."""

    n: int
    holds: bool
    code: str = ""
    reason: str = ""
    holder: str = ""


class Wish(Struct, frozen=True, kw_only=True):
    """The latest request of a page: its motion, since when, and the time of its last message. `rests` counts its
    releases. `speed` is the share of speed that the age of its messages allows."""

    wanted: Wanted | None = None
    since: float = nan
    at: float = nan
    speed: float = 1.0
    rests: int = 0
    is_over: bool = False


class Hand:
    """A page's hold on the robot: its socket writes `wish`, and the loop everything else.

    - `may`: returns the reason why this page may not have a motion, or None.
    - `tell`: receives the news.
    - `whose`: the owner of the hand, in words.
    - `resumes`: the hand continues a motion that lapsed or came late under the same number, dated by its first message.
      After a stop since then the mover refuses it. Other pages receive the news, and begin again.
    """

    def __init__(
        self,
        source: str,
        may: Callable[[Wanted], Reason | None],
        tell: Callable[[HoldNews], None],
        whose: str = "the page",
        *,
        resumes: bool = False,
    ) -> None:
        self.source = source
        self.whose = whose
        self.resumes = resumes
        self.may = may
        self.tell = tell
        self.wish = Wish()
        self.lease: LeaseClient | None = None
        self.wanted: Wanted | None = None
        self.news = HoldNews(n=0, holds=False)
        self.over_n: int | None = None
        self.ended: Reason | None = None
        self.rests = 0
        self.refused_s = nan

    def hold(self, wanted: Wanted, at: float, speed: float = 1.0) -> None:
        """Request motion, at a share of its speed."""
        before = self.wish.wanted
        since = self.wish.since if before is not None and before.n == wanted.n else at
        self.wish = replace(self.wish, wanted=wanted, since=since, at=at, speed=speed)

    def keep(self, n: int, at: float, speed: float = 1.0) -> None:
        """Keep requesting the motion with that number."""
        if self.wish.wanted is not None and self.wish.wanted.n == n:
            self.wish = replace(self.wish, at=at, speed=speed)

    def release(self, *, for_good: bool = False) -> None:
        """Request no motion; `for_good`: the page is gone."""
        self.wish = Wish(rests=self.wish.rests + 1, is_over=for_good or self.wish.is_over)

    def over(self, why: Reason) -> bool:
        """Return whether the motion is over after an end for this reason."""
        return why.code != "cancelled" and not (self.resumes and why.code in {"lapsed", "late"})


class Holds:
    """All hands; only `add` may be called outside the loop.

    - `transport`: leases motion for a source, dated by the hand's `Origin`. Every later stop ends the motion, even a
      stop by the same source, which may have other hands.
    - `keys`: those of the held command (`motion`) and of its capability's stop (`halt`, if it has one).
    - `slowed`: returns a motion's message with a share of its speed.
    - `patience_s`: how long a page may be silent during a motion. To begin one it needs a message of the last
      `SILENT_S`.
    """

    def __init__(
        self,
        transport: Callable[[str, Mapping[str, str], Origin], Transport],
        keys: Callable[[Wanted], Mapping[str, str]],
        clock: Callable[[], float] = time.monotonic,
        patience_s: Callable[[Wanted], float] = lambda _wanted: SILENT_S,
        slowed: Callable[[Wanted, float], Mapping[str, object]] = lambda wanted, _speed: wanted.message,
    ) -> None:
        self._slowed = slowed
        self._patience_s = patience_s
        self._transport = transport
        self._keys = keys
        self._clock = clock
        self._hands: set[Hand] = set()
        self._leaving: list[tuple[LeaseClient, str, bool]] = []

    def add(self, hand: Hand) -> None:
        """Serve a hand until it is over."""
        self._hands.add(hand)

    def step(self) -> None:
        """Do one round of work for each hand."""
        for hand in tuple(self._hands):
            self._step(hand, self._clock())
            if hand.wish.is_over and hand.lease is None:
                self._hands.discard(hand)
        for one in tuple(self._leaving):
            if self._is_given_up(*one):
                self._leaving.remove(one)

    def close(self, why: str) -> None:
        """Release everything, as the server ends."""
        for hand in tuple(self._hands):
            self._release(hand, Reason("shutting_down", why), lost=True)
        self._hands.clear()

    def _step(self, hand: Hand, now: float) -> None:
        wish = hand.wish
        patience_s = self._silent_s(hand, wish)
        fresh = now - wish.at <= patience_s  # false for NaN
        rested = wish.rests != hand.rests
        hand.rests = wish.rests
        if rested:
            hand.over_n, hand.refused_s = None, nan
        if rested or not fresh:
            hand.ended = None
        wanted = wish.wanted if fresh else None
        self._follow(hand)
        if hand.lease is not None and (rested or wanted is None or hand.wanted is None or wanted.to != hand.wanted.to):
            self._release(
                hand,
                _why(hand.whose, wish, patience_s, rested=rested, wanted=wanted),
                lost=wish.is_over or (wanted is None and not rested),
            )
        if wanted is None or wanted.n == hand.over_n:
            return
        if hand.lease is None:
            self._begin(hand, wanted, now)
        else:
            self._keep(hand, hand.lease, wanted)

    def _silent_s(self, hand: Hand, wish: Wish) -> float:
        """Return how long a hand's page may be silent; longer only while it holds the motion that it requests."""
        held = hand.wanted if hand.lease is not None and hand.lease.holds else None
        if held is None or wish.wanted is None or held.n != wish.wanted.n:
            return SILENT_S
        return max(SILENT_S, self._patience_s(wish.wanted))

    def _follow(self, hand: Hand) -> None:
        """Read the robot's answers, and note the end of a lease."""
        if (lease := hand.lease) is None:
            return
        with self._bus_of(hand):
            lease.step()
        if lease.ended is not None and hand.lease is not None:
            hand.lease = None
            self._refuse(hand, lease.ended)

    def _begin(self, hand: Hand, wanted: Wanted, now: float) -> None:
        if now - hand.refused_s < AGAIN_S:
            return
        hand.wanted = wanted
        if hand.ended is not None:
            ended = hand.ended
            self._refuse(hand, Reason("rest_first", f"{ended.text}: {REST}"))
            hand.ended = ended
        elif why := hand.may(wanted):
            self._refuse(hand, why)
        else:
            keys = self._keys(wanted)
            target = LeaseTarget("motion", halt="halt" if "halt" in keys else "")
            with self._bus_of(hand):
                message = self._slowed(wanted, hand.wish.speed)
                origin = Origin(f"a hand of {hand.source}", hand.wish.since)
                hand.lease = LeaseClient(self._transport(hand.source, keys, origin), target, message)

    def _keep(self, hand: Hand, lease: LeaseClient, wanted: Wanted) -> None:
        hand.wanted = wanted
        with self._bus_of(hand):
            lease.keep(self._slowed(wanted, hand.wish.speed))
        if hand.lease is not None and lease.holds:
            self._tell(hand, HoldNews(n=wanted.n, holds=True))

    def _release(self, hand: Hand, why: Reason, *, lost: bool) -> None:
        """Release a lease. One that is not granted yet cannot stop the motion, and is released once it is granted."""
        lease, hand.lease = hand.lease, None
        if lease is None:
            return
        if hand.wanted is not None and hand.over(why):
            hand.over_n = hand.wanted.n
        if lease.accepted is None:
            self._leaving.append((lease, why.text, lost))
        else:
            with self._bus_of(hand):
                lease.release(why.text, lost=lost)
        own = why.code == "cancelled"  # a page knows its own releases
        self._tell(
            hand, HoldNews(n=_number(hand), holds=False, code="" if own else why.code, reason="" if own else why.text)
        )

    def _is_given_up(self, lease: LeaseClient, why: str, lost: bool) -> bool:
        """Step a lease to be released; return whether it was refused or released."""
        try:
            lease.step()
            if lease.ended is None and lease.accepted is not None:
                lease.release(why, lost=lost)
        except BusError:
            return True
        return lease.ended is not None

    def _refuse(self, hand: Hand, why: Reason) -> None:
        hand.refused_s = self._clock()
        if hand.over(why):
            hand.over_n = _number(hand)
            hand.ended = why if why.code in ENDED_BY_OTHERS else None
        self._tell(hand, HoldNews(n=_number(hand), holds=False, code=why.code, reason=why.text, holder=why.holder))

    @contextmanager
    def _bus_of(self, hand: Hand) -> Iterator[None]:
        """Treat a lost bus as a lost lease."""
        try:
            yield
        except BusError as err:
            hand.lease = None
            self._refuse(hand, Reason("unreachable", str(err)))

    def _tell(self, hand: Hand, news: HoldNews) -> None:
        before, hand.news = hand.news, news
        if news != before and not (news.holds and before.holds):
            hand.tell(news)


def _number(hand: Hand) -> int:
    return hand.wanted.n if hand.wanted is not None else 0


def _why(whose: str, wish: Wish, patience_s: float, *, rested: bool, wanted: Wanted | None) -> Reason:
    """Return why a lease is released; without a message of its page it lapses."""
    if wish.is_over:
        return Reason("holder_gone", GONE.format(whose))
    if wanted is None and not rested:
        return Reason("lapsed", SILENT.format(whose, patience_s))
    return Reason("cancelled", RELEASED.format(whose))
