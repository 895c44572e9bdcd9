"""A face's handlers, called as the server calls them."""

from collections.abc import Mapping
from typing import Any

from starlette.responses import Response

from lbr.apps.web.contract import contract, response
from lbr.apps.web.face import Client, Request, Route


def called(
    route: Route, client: Client, *, params: Any = None, body: Any = None, headers: Mapping[str, str] | None = None
) -> Any:
    """Return what a route answers, or the coroutine that will."""
    request = Request(method=route.method, path=route.path, client=client, headers=headers or {})
    given = {"request": request, "client": client, "params": params, "body": body}
    promised = contract(route)
    arguments = {name: given[name] for name in promised.takes}

    async def waited() -> Response:
        return response(await route.handle(**arguments))

    return waited() if promised.waits else response(route.handle(**arguments))
