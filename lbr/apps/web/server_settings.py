"""The settings of every row with a server."""

from typing import Annotated

from msgspec import Meta, Struct


class ServerSettings(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Where a server listens, and how it is reached."""

    host: Annotated[str, Meta(description="where to listen; 0.0.0.0 for every network")] = "127.0.0.1"
    port: Annotated[int, Meta(ge=0, le=65535, description="0: any free one")] = 0
    tls: Annotated[bool, Meta(description="TLS also where only this machine reaches it")] = False
    clear_text: Annotated[bool, Meta(description="no TLS to other machines: all in between read and change it")] = False
    names: Annotated[tuple[str, ...], Meta(description="this machine's other names, such as robot.example.org")] = ()

    def __post_init__(self) -> None:
        """Refuse settings that contradict each other."""
        if self.tls and self.clear_text:
            raise ValueError("tls and clear_text: only one of them can be true")

    @property
    def trusted(self) -> tuple[str, ...]:
        """Return the networks whose clients need no token."""
        return ()
