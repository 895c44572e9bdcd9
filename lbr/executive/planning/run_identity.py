"""The identity of a run: its places, and the secret from which its names, seals and passwords are derived."""

from hashlib import blake2b

from msgspec import Struct

from lbr.bus.access import Credentials


class RunIdentity(Struct, frozen=True, kw_only=True):
    """The facts of this run that a plan needs: its places, and the secret of its seals and passwords.

    `listen` are the endpoints for other machines from the command line.
    """

    home: str
    endpoints: tuple[str, ...]
    secret: bytes
    listen: tuple[str, ...] = ()
    token_key: bytes = b""

    def seal(self, key: str) -> str:
        """Return the key that seals a setpoint, the same for every plan of this run."""
        return blake2b(key.encode(), key=self.secret, digest_size=32).hexdigest()

    def router_id(self, name: str) -> str:
        """Return the session id of one of this run's routers; the other routers know it by that."""
        return f"1{self.seal(f'router {name}')[:15]}"  # an id must not begin with 0

    def credentials(self, user: str) -> Credentials:
        """Return the credentials of a process on the bus, the same for every plan of this run."""
        return Credentials(user=user, password=self.seal(f"password of {user}"))
