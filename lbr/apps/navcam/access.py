"""Access to navcam by the token of this home, or by a cookie for it, and from no address without."""

import secrets
from collections.abc import Mapping
from pathlib import Path

from lbr import home
from lbr.apps.web.face import Client, Refused
from lbr.apps.web.login import Login
from lbr.errors import InputError

TOKEN_FILE = "navcam.token"  # noqa: S105 - a file's name
NAME = "navcam"
NO_TOKEN = (
    "show the token: 'Authorization: Bearer TOKEN', or open the address that navcam printed in a browser; "
    f"it is in credentials/{TOKEN_FILE} of the robot's home"
)


def token() -> str:
    """Return this home's token, made on first use; removing its file locks all users out."""
    (path,) = home.credentials(lambda: [secrets.token_urlsafe(32).encode()], TOKEN_FILE)
    return _read_private(path)


def _read_private(path: Path) -> str:
    text = path.read_text(errors="replace").strip()
    if len(text) < 32 or not text.isascii():
        raise InputError(f"{path} holds no token; remove it, and a new one is made")
    return text


class TokenAccess:
    """Checks the token, in constant time, and the cookies that stand for it."""

    def __init__(self, secret: str, login: Login) -> None:
        self._secret = secret.encode()
        self._login = login

    def client(
        self,
        address: str,
        headers: Mapping[str, str],
        token: str = "",
        *,
        port: int = 0,
        owner: bool = False,
        whose: str | None = None,
    ) -> Client:
        """Return the client; raise Refused (401) without the token or a cookie, from any address."""
        del port, owner
        if not token:
            scheme, _, token = headers.get("authorization", "").partition(" ")
            token = token.strip() if scheme.lower() == "bearer" else ""
        if secrets.compare_digest(token.encode(), self._secret):
            return Client(address, name=NAME, role="view")
        session = self._login.session(headers, whose)
        if not session:
            raise Refused(401, NO_TOKEN, {"WWW-Authenticate": 'Bearer realm="lbr navcam"'})
        return Client(address, role="view", session=session)
