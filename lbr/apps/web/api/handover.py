"""A person who wants what another holds asks for it, and the holder hands it over. Both are only told: who has the
lease moves until it is released, and who asked begins as always."""

from collections.abc import Callable
from typing import Annotated, Any

from msgspec import Meta, Struct
from starlette.responses import Response

from lbr.apps.http.rates import Rates
from lbr.apps.web.api.catalog import Catalog
from lbr.apps.web.api.requests import source_of
from lbr.apps.web.face import Message, Refused, Request, Route, json
from lbr.messages.units import Name

ASKED, HANDED = "asked_for", "handed_over"
OFTEN_HZ = 0.5
"""A sentence in everybody's events: a person may say it again every two seconds."""
Tell = Callable[[str, str, dict[str, Any]], None]


class AskBody(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """What is wanted."""

    capability: Name


class HandOverBody(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """What was released, and for whom: the `by` of the event that asked."""

    capability: Name
    to: Annotated[str, Meta(max_length=80)]


class Handover:
    """The two routes; `tell` publishes an event of a kind, with its sentence and data."""

    def __init__(self, catalog: Callable[[], Catalog], tell: Tell, clock: Callable[[], float]) -> None:
        self._catalog = catalog
        self._tell = tell
        self._clock = clock
        self._rates = Rates(OFTEN_HZ)

    def routes(self) -> list[Route]:
        """Return them."""
        refuses = {404: "Nothing of this name on this robot is held.", 429: "You said so two seconds ago."}
        return [
            Route(
                method="POST", path="/api/ask", handle=self._ask, summary="Ask the holder for what it holds",
                description=f"Told as event `{ASKED}`, with `by` in its data; the holder's page shows it.",
                replies={200: Message}, body=AskBody, role="operate", refuses=refuses,
            ),
            Route(
                method="POST", path="/api/hand_over", handle=self._hand_over,
                summary="Say that you released something for another",
                description=f"Told as event `{HANDED}`, with `by` and `to` in its data. It moves and ends nothing.",
                replies={200: Message}, body=HandOverBody, role="operate", refuses=refuses,
            ),
        ]  # fmt: skip

    async def _ask(self, request: Request) -> Response:
        by, what = self._who(request), request.data.capability
        self._tell(ASKED, f"{by} asks for {what}", {"capability": what, "by": by})
        return json(Message(message="told to who holds it"))

    async def _hand_over(self, request: Request) -> Response:
        by, what, to = self._who(request), request.data.capability, request.data.to
        self._tell(HANDED, f"{by} hands {what} over to {to}", {"capability": what, "by": by, "to": to})
        return json(Message(message="told"))

    def _who(self, request: Request) -> str:
        by, what = source_of(request.client), request.data.capability
        held = (command.leased for name, command in self._catalog().commands.items() if name.startswith(f"{what}/"))
        if not any(held):
            raise Refused(404, f"there is nothing '{what}' on this robot that is held; GET /api names what there is")
        if not self._rates.take(f"{request.path} {by}", self._clock()):
            raise Refused(429, f"{by} said so two seconds ago", {"Retry-After": "2"})
        return by
