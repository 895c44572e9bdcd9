"""Speech: text to sound in a process of its own, then to a sink that reports whether it played."""

from lbr.component import Component

COMPONENT = Component(kinds={"speech": "lbr.apps.speech.kind:KIND"})
