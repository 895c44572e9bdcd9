"""The robot over HTTP: one server for all faces; settings decide which faces it shows, and to whom."""

from lbr.component import CliCommand, Component

COMPONENT = Component(
    kinds={"web": "lbr.apps.web.kind:KIND"},
    commands={
        "phone": CliCommand("lbr.apps.web.commands.phone:command", "Connect a phone: show one code to scan.", "start")
    },
    faces={
        "cameras": "lbr.apps.web.cameras.ports:face",
        "model": "lbr.apps.web.model.routes:ModelFace",
        "page": "lbr.apps.web.page.files:face",
    },
    ports={"cameras": "lbr.apps.web.cameras:PORTS", "model": "lbr.apps.web.model:PORTS"},
    checks={"web": "lbr.apps.web.commands.checks:ports"},
    public=(
        "lbr.apps.web.access",
        "lbr.apps.web.api",
        "lbr.apps.web.application",
        "lbr.apps.web.bridge",
        "lbr.apps.web.cameras",
        "lbr.apps.web.contract",
        "lbr.apps.web.face",
        "lbr.apps.web.front",
        "lbr.apps.web.guards",
        "lbr.apps.web.login",
        "lbr.apps.web.ports",
        "lbr.apps.web.robot",
        "lbr.apps.web.server_settings",
        "lbr.apps.web.sessions",
        "lbr.apps.web.viewing",
    ),
    needs=("motions",),
)
