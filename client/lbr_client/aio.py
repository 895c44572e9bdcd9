"""The same robot for programs that run in an event loop: what `lbr.client.aio` has."""

from lbr.client.aio import AsyncMotion, AsyncRobot, connect

__all__ = ["AsyncMotion", "AsyncRobot", "connect"]
