"""Robots that are up, and how to reach them: a small service (`lbr registry`), and the kind `registrar` for a robot.

`book` has the service's records, and is pure; `guests` are the tokens that it has issued; `server` answers over HTTPS.
`asking` sends requests to it; `capability` registers a robot.
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
