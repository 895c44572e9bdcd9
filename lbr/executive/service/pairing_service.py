"""Answers devices that show a code: with a token at once, or late, and always in the same words. Keeps codes secret."""

import math
from collections import deque
from collections.abc import Callable

from lbr.bus import stamp, wire
from lbr.bus.codec import Decoder
from lbr.bus.door import LanUser
from lbr.database.store import Database
from lbr.errors import LbrError, MalformedError
from lbr.executive.planning import credentials
from lbr.executive.planning.event_sink import EventSink
from lbr.executive.planning.live_rows import LiveRows
from lbr.executive.planning.wiring import EXECUTIVE
from lbr.executive.service import pairing as codes
from lbr.executive.service.pairing import Pairing, Try
from lbr.executive.services import Service
from lbr.messages.codes import Code
from lbr.messages.pairing import PairCommand, PairReply
from lbr.messages.plain import one_line

DELAY_S = 1.0
"""The delay of an answer to a wrong try: a person does not notice, and many tries in parallel gain nothing."""
MOST_WAITING = 32
"""The number of wrong tries that wait for their answers; beyond it, no more are checked."""
TOLD_EVERY_S = 60.0
"""Tries without a code are reported together: they cannot be right, and anybody may make them."""
NOT_GOOD = "this code is not good: wrong, used, or over; 'phone' at the robot's console shows a new one"
NOT_SERVED = "this process lets no phones in"
_commands = Decoder(PairCommand)


class Grants:
    """Makes the tokens: rows as `lbr token add` writes them, valid for the web.

    `runs_since(name)` is when the process of a capability was started.
    """

    def __init__(
        self, database: Database, rows: LiveRows, *, runs_since: Callable[[str], float], happened: EventSink
    ) -> None:
        self._database = database
        self._rows = rows
        self._runs_since = runs_since
        self._happened = happened

    def pairs(self, name: str) -> bool:
        """Return whether a capability may show codes; the bus admits no other, but a stamp's name is only a claim."""
        plan = self._rows.plan
        return name in plan.units and plan.kinds[name].rights.pairs

    def grant(self, name: str, code: codes.Code, asked: PairCommand, *, since_s: float) -> PairReply:
        """Make the token for a right code, for a device that came by a capability, which asked at `since_s`."""
        names = [one.name for one in self._database.tokens()]
        address = one_line(asked.address)
        made = credentials.new_token(
            self._database, credentials.device_name(asked.name, names), code.role, good_for="web", paired_from=address
        )
        token = made.token
        if self._runs_since(name) < since_s:
            self._rows.knows(name, [LanUser(name=token.name, role=code.role, secret=token.secret, hash=made.hash)])
        else:
            self._rows.look_again()  # the running process did not ask, and is restarted with the token
        text = f"token '{token.name}' ({code.role}) was made for {address}, by the code that {code.by} asked for"
        self._happened("paired", name, text)
        return PairReply(accepted=True, token=str(token), name=token.name, role=code.role, hash=made.hash)


class PairingService(Service):
    """Receives codes by `served`, and gives tokens by `grants`; the main thread calls `step`."""

    def __init__(self, served: wire.QueryServer, pairing: Pairing, grants: Grants, *, happened: EventSink) -> None:
        self._served = served
        self._pairing = pairing
        self._grants = grants
        self._happened = happened
        self._late: deque[tuple[float, wire.Request]] = deque()
        self._unheard = 0
        self._tell_at = 0.0

    def step(self, now: float) -> float:
        """Answer what is due, and return when the next answer is."""
        for request in self._served.take():
            self._take(request, now)
        while self._late and self._late[0][0] <= now:
            self._late.popleft()[1].reply(_refused(NOT_GOOD, "token"), EXECUTIVE)
        return self._late[0][0] if self._late else math.inf

    def close(self) -> None:
        """Accept no more codes, and answer the waiting requests."""
        self._served.close()
        self._pairing.cancel()
        while self._late:
            self._late.popleft()[1].reply(_refused(NOT_GOOD, "token"), EXECUTIVE)

    def _take(self, request: wire.Request, now: float) -> None:
        found = stamp.read(request.attachment)
        name = found.source if found is not None else ""
        if not self._grants.pairs(name):
            request.reply(_refused(NOT_SERVED, "denied"), EXECUTIVE)
            return
        if len(self._late) >= MOST_WAITING:
            request.reply(_refused("too many codes are tried at once; try again", "busy"), EXECUTIVE)
            return
        try:
            asked = _commands.decode(request.payload)
        except MalformedError as err:
            request.reply(_refused(f"malformed: {err}", "malformed"), EXECUTIVE)
            return
        tried = self._pairing.attempt(asked.digits, asked.address)
        if tried.code is None:
            self._late.append((now + DELAY_S, request))
            self._tell(name, one_line(asked.address), tried, now)
            return
        try:
            reply = self._grants.grant(name, tried.code, asked, since_s=request.arrived)
        except LbrError as err:
            reply = _refused(f"{err}; the code is used up, so ask for a new one ('phone')", "failed")
        request.reply(reply, EXECUTIVE)

    def _tell(self, name: str, address: str, tried: Try, now: float) -> None:
        wrong = f"{address} tried a wrong code ({tried.from_there} from there since the start)"
        if tried.tries_left is None:
            self._unheard += 1
            if now < self._tell_at:
                return
            self._tell_at = now + TOLD_EVERY_S
            tries = "a code was tried" if self._unheard == 1 else f"{self._unheard} codes were tried"
            text = f"{tries} while none was good, the last by {address} ({tried.from_there} from there since the start)"
            self._unheard = 0
        elif tried.tries_left:
            text = f"{wrong}; {tried.tries_left} more, and it ends"
        else:
            text = f"{wrong}: that was one too many, and it has ended"
        self._happened("pair_refused", name, text, "warning")


def _refused(reason: str, code: Code) -> PairReply:
    return PairReply(accepted=False, reason=reason, code=code)
