"""Signing in: a browser sends a token once and receives a cookie, which allows looking and stopping, and nothing
else."""

from collections.abc import Mapping
from http.cookies import CookieError, SimpleCookie
from typing import Annotated

from starlette.responses import Response

from lbr.apps.web.face import Client, Refused, post, route
from lbr.apps.web.sessions import LIFE_S, Sessions, name_in


class Login:
    """The routes to sign in and out, which set and delete cookies of this `name`; with `tls` for https only."""

    def __init__(self, sessions: Sessions, name: str, *, tls: bool) -> None:
        self.sessions = sessions
        self._name = f"{'__Host-' if tls else ''}{name}"
        self._tls = tls

    def session(self, headers: Mapping[str, str], whose: str | None) -> str:
        """Return the mark of the session of a request's cookie; empty without one, or if its user is unknown."""
        cookie = self._cookie(headers)
        return self.sessions.find(cookie, whose) if cookie and whose is not None else ""

    @post("/session", role="known")
    def _begin(self, client: Client) -> Annotated[Response, {204: None}]:
        """Exchange a token for a cookie."""
        if not client.name:
            raise Refused(401, "show the token itself: 'Authorization: Bearer TOKEN'")
        response = Response(status_code=204)
        self.give(response, client.name, client.whose)
        return response

    def give(self, response: Response, name: str, whose: str | None) -> None:
        """Add a token's cookie to a response, unless the user of the client's program is unknown."""
        if whose is None:
            return
        cookie = self.sessions.begin(name, whose)
        response.set_cookie(
            self._name, cookie, max_age=LIFE_S, path="/", httponly=True, samesite="strict", secure=self._tls
        )

    @route("DELETE", "/session", role=None)
    def _end(self, client: Client) -> Annotated[Response, {204: None}]:
        """End the session of the cookie."""
        self.sessions.end(client.session)
        return self._signed_out()

    @route("DELETE", "/sessions", role="known")
    def _end_all(self, client: Client) -> Annotated[Response, {204: None}]:
        """End all sessions of the client's token."""
        self.sessions.end_all(name_in(client.mark))
        return self._signed_out()

    def _signed_out(self) -> Response:
        response = Response(status_code=204)
        response.delete_cookie(self._name, path="/", httponly=True, samesite="strict", secure=self._tls)
        return response

    def _cookie(self, headers: Mapping[str, str]) -> str:
        cookies: SimpleCookie = SimpleCookie()
        try:
            cookies.load(headers.get("cookie", ""))
        except CookieError:
            return ""
        return cookies[self._name].value if self._name in cookies else ""
