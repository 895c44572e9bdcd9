"""Robots that are up, and how to reach them: a small service (`lbr registry`), and what tells it of a robot (kind
`registrar`).

`book` is what the service knows, pure; `guests` are the tokens that it has given; `server` answers over HTTPS; `asking`
is the way there; `capability` registers a robot.
"""

from lbr.component import CliCommand, Component

COMPONENT = Component(
    kinds={"registrar": "lbr.apps.registry.kind:KIND"},
    commands={
        "registry": CliCommand(
            "lbr.apps.registry.commands.registry:command",
            "List which robots are up and how to reach them, or run the service that does.",
            "run for good",
        ),
    },
    messages=("lbr.apps.registry.messages",),
)
