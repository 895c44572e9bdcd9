"""A face's handlers, called as the server calls them."""

import time
from collections.abc import Mapping
from pathlib import Path
from types import SimpleNamespace
from typing import Any

from starlette.responses import Response

from lbr.apps.web.contract import contract, response
from lbr.apps.web.face import Client, Request, Route


def modelled(home: Path, **more: Any) -> Any:
    """Return a robot as the face `model` knows it, without a server."""
    ctx = SimpleNamespace(home=str(home), rows=lambda _row: ())
    return SimpleNamespace(name="bioloid", ctx=ctx, now=time.monotonic, motors=(), **more)


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
