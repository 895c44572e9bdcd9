"""Telemetry: all states of the robot in one nested message, with the age of each part."""

from lbr.component import Component

COMPONENT = Component(kinds={"telemetry": "lbr.apps.telemetry.kind:KIND"})
