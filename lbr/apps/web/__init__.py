"""The robot over HTTP: one server for all faces; which of them it shows, and to whom, are settings."""

from lbr.component import Component

COMPONENT = Component(
    kinds={"web": "lbr.apps.web.kind:KIND"},
    faces={
        "call": "lbr.apps.web.call:face",
        "cameras": "lbr.apps.web.cameras:face",
        "model": "lbr.apps.web.model:face",
        "page": "lbr.apps.web.page:face",
    },
    ports={
        "call": "lbr.apps.web.call:PORTS",
        "cameras": "lbr.apps.web.cameras:PORTS",
        "model": "lbr.apps.web.model:PORTS",
    },
)
