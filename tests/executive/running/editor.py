"""An app that edits rows for whoever asks it, as a file of a user's own; and one that only has the same rows."""

from dataclasses import replace

import msgspec
from msgspec import Struct

from lbr.capability import Capability, Kind, Rights
from lbr.messages.faces import EditCommand, EditReply, Motor
from lbr.messages.joints import MotionRow, MotionStep

EDITED = (MotionRow, MotionStep, Motor)


class Settings(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    pass


class Known(Struct, frozen=True):
    motors: tuple[str, ...]
    motions: tuple[str, ...]


class Editor(Capability[Settings]):
    def open(self) -> None:
        self.asked = []

    def step(self) -> None:
        names = tuple(motor.name for motor in (self.ctx.rows(Motor) if "motor" in self.ctx.config.rows else ()))
        self.ctx.publish("known", Known(names, tuple(motion.name for motion in self.ctx.rows(MotionRow))))
        for call, edit, asked in list(self.asked):
            answers = asked.answers()
            if answers is not None:
                self.asked.remove((call, edit, asked))
                reply = answers["executive"] or EditReply(accepted=False, reason="nobody answered")
                if reply.accepted:
                    for row in EDITED:
                        self.ctx.adopt(msgspec.json.decode(edit.rows.get(row.TABLE, b"[]"), type=list[row]))
                call.reply(reply)

    def command(self, call) -> None:
        if not self.ctx.targets("edit"):
            call.refuse("not wired")
            return
        self.asked.append((call, call.message, self.ctx.ask("edit", call.message, 6.0)))


KIND = Kind(
    name="editor",
    summary="edits rows",
    family="app",
    entry=Editor,
    settings=Settings,
    outputs={"known": Known},
    commands={"write": EditCommand},
    requests={"edit": EditCommand},
    replies={"edit": EditReply, "write": EditReply},
    rows=EDITED,
    rights=Rights(edits=EDITED),
)
ONLOOKER = replace(KIND, name="onlooker", rows=(MotionRow, MotionStep), rights=Rights())
