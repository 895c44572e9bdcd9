"""The routes of calls. The client and its role are passed on: the call's own process decides."""

from typing import Annotated

from msgspec import Meta, Struct

from lbr.apps.call.messages import KeepCommand, Offer, Purpose, RingCommand, RingReply
from lbr.apps.web.contract import Refuses
from lbr.apps.web.face import Client, Face, Refused, post
from lbr.apps.web.robot import Robot

RING_S, KEEP_S = 2.0, 1.5
STATUSES = {"role": 403, "busy": 409, "malformed": 400, "not_possible": 400, "idle": 409}
LONGEST_ID = 40
NOT_RUNG = Refuses(
    {
        403: "The row wants another role.",
        409: "Another calls, or enough watch by WebRTC.",
        503: "The call is not wired, or its process is away: there is MJPEG.",
    }
)


class RingBody(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """The purpose of a page's call, and its offer."""

    purpose: Annotated[
        Purpose, Meta(description="talk: a call; watch: its picture alone; display: show the caller")
    ] = "talk"
    offer: Offer


class KeepBody(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """The report of a page; `leave`: it leaves."""

    leave: bool = False


class CallFace(Face):
    """The routes. They require a `known` client, as those of the cameras do; a trusted address is not enough."""

    name = "call"

    def __init__(self, robot: Robot) -> None:
        self._robot = robot

    @post("/call", role="known", within_s=RING_S + 1.0)
    async def _ring(self, client: Client, body: RingBody) -> Annotated[RingReply, NOT_RUNG]:
        """Call the robot, or watch it, by WebRTC.

        The offer is a browser's (SDP), with all its addresses. The answer to it comes by `POST /call/{id}`, which the
        page must repeat each second while the call goes on.
        """
        asked = RingCommand(purpose=body.purpose, offer=body.offer, by=str(client)[:120], role=client.role)
        reply = await self._robot.ask("call_ring", asked, timeout_s=RING_S)
        return _answered(reply, STATUSES.get(reply.code, 503))

    @post("/call/{id}", role="known", within_s=KEEP_S + 1.0)
    async def _keep(
        self, id_: str, body: KeepBody | None = None
    ) -> Annotated[RingReply, Refuses({404: "The call is over; the message has the reason."})]:
        """Keep a call, or leave it."""
        if not 1 <= len(id_) <= LONGEST_ID:
            raise Refused(404, "there is no such call")
        asked = KeepCommand(id=id_, leave=body is not None and body.leave)
        return _answered(await self._robot.ask("call_keep", asked, timeout_s=KEEP_S), 404)


def _answered(reply: RingReply, status: int) -> RingReply:
    if not reply.accepted:
        raise Refused(status, reply.reason, code=reply.code or "refused")  # type: ignore[arg-type]
    return reply
