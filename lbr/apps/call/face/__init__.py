"""The call as a face: a page rings, keeps its call and leaves it; picture and sound do not pass this server."""

from lbr.apps.call.messages import KeepCommand, RingCommand, RingReply
from lbr.apps.web.ports import FacePorts

PORTS = FacePorts(
    requests={"call_ring": RingCommand, "call_keep": KeepCommand},
    replies={"call_ring": RingReply, "call_keep": RingReply},
)
