"""Tracking: the head follows a coloured thing or a face that its camera sees, under a lease as anybody else's motion."""

from lbr.component import Component

COMPONENT = Component(
    kinds={"tracking": "lbr.apps.tracking.kind:KIND"},
)
