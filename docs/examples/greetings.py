"""Greets those named by a row of a table of its own, and counts how often: rows that a kind brings, and learns."""

from typing import Annotated

from msgspec import Meta, Struct, structs

from lbr.capability import Call, Capability, Command, Kind, NoSettings, Row, Rows, names
from lbr.messages.leases import CommandReply
from lbr.messages.units import Name


class Greeting(Row, frozen=True, kw_only=True):
    """What is said to whom, and how often it was."""

    TABLE = "greeting"
    KEY = ("name",)

    name: Name
    text: Annotated[str, Meta(min_length=1, max_length=200)]
    said: Annotated[int, Meta(ge=0, le=1_000_000)] = 0


class GreetCommand(Struct, frozen=True, kw_only=True):
    """Greet a person that a row names."""

    name: Name


class Greeter(Capability[NoSettings]):
    """Answers with the text of a row, and writes down that it was said."""

    def command(self, call: Call) -> None:
        """Greet."""
        greeting = next((row for row in self.ctx.rows(Greeting) if row.name == call.message.name), None)
        if greeting is None:
            call.refuse(f"there is no row of 'greeting' for {call.message.name}")
            return
        self.ctx.learn(structs.replace(greeting, said=greeting.said + 1))
        call.reply(CommandReply(accepted=True, reason=greeting.text))


KIND = Kind(
    name="greetings",
    summary="greets by rows of its own",
    family="app",
    entry=Greeter,
    commands={"greet": Command(GreetCommand, choices={"name": names(Greeting)})},
    replies={"greet": CommandReply},
    rows=(Rows(Greeting, learnt=True),),
)
