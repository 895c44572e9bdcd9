"""Requests and handovers of a lease between people. Both only publish an event.

The holder moves until it releases the lease, and the other person begins as always.
"""

from typing import Annotated

from msgspec import Meta, Struct

from lbr.apps.http.rates import Rates
from lbr.apps.web.api.requests import source_of
from lbr.apps.web.api.service import Api
from lbr.apps.web.contract import Refuses
from lbr.apps.web.face import Client, Message, Refused, post
from lbr.messages.units import Name

ASKED, HANDED = "asked_for", "handed_over"
OFTEN_HZ = 0.5
"""A request is an event that everybody sees, so a person may repeat it only every two seconds."""
REFUSES = Refuses({404: "Nothing of this name on this robot is held.", 429: "You asked within the last two seconds."})


class AskBody(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """The wanted lease."""

    capability: Name


class HandOverBody(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """The released lease, and its next holder: the `by` of the event with the request."""

    capability: Name
    to: Annotated[str, Meta(max_length=80)]


class Handover:
    """The two routes."""

    def __init__(self, api: Api) -> None:
        self._api = api
        self._rates = Rates(OFTEN_HZ)

    @post("/api/ask", role="operate")
    async def _ask(self, client: Client, body: AskBody) -> Annotated[Message, REFUSES]:
        """Ask the holder to hand its lease over. Publishes the event `asked_for`, with `by` in its data; the holder's
        page shows it."""
        by, what = self._sender("ask", client, body.capability), body.capability
        self._api.tell(ASKED, f"{by} asks for {what}", {"capability": what, "by": by})
        return Message(message="the holder was asked")

    @post("/api/hand_over", role="operate")
    async def _hand_over(self, client: Client, body: HandOverBody) -> Annotated[Message, REFUSES]:
        """Announce that you released a lease for another person. Publishes the event `handed_over`, with `by` and `to`
        in its data. It moves and ends nothing."""
        by, what, to = self._sender("hand over", client, body.capability), body.capability, body.to
        self._api.tell(HANDED, f"{by} hands {what} over to {to}", {"capability": what, "by": by, "to": to})
        return Message(message="told")

    def _sender(self, verb: str, client: Client, part: str) -> str:
        by = source_of(client)
        held = (command.leased for name, command in self._api.catalog().commands.items() if name.startswith(f"{part}/"))
        if not any(held):
            raise Refused(404, f"there is nothing '{part}' on this robot that is held; GET /api names what there is")
        if not self._rates.take(f"{verb} {by}", self._api.now()):
            raise Refused(429, f"{by} asked within the last two seconds", {"Retry-After": "2"})
        return by
