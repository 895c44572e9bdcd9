"""Cameras: one of several is on at a time, chosen by name."""

from lbr.component import Component

COMPONENT = Component(kinds={"cameras": "lbr.apps.cameras.kind:KIND"})
