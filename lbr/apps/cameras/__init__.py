"""Cameras: one of several on at a time, by name."""

from lbr.component import Component

COMPONENT = Component(
    kinds={"cameras": "lbr.apps.cameras.kind:KIND"},
)
