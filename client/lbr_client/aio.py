"""The same robot for programs with an event loop: the exports of `lbr.client.aio`."""

from lbr.client.aio import AsyncMotion, AsyncRobot, connect

__all__ = ["AsyncMotion", "AsyncRobot", "connect"]
