"""The thread in which the server runs."""

import threading

from lbr.apps.http import listening
from lbr.apps.web import serving
from lbr.apps.web.serving import Serving
from tests.support.waiting import until


async def app(_scope, _receive, _send):
    """Answer nothing."""


def test_a_server_that_is_held_up_while_it_is_told_to_end_closes_its_own_sockets(monkeypatch):
    """A socket that another thread closed would break its end."""
    monkeypatch.setattr(serving, "JOIN_S", 0.01)
    held, go_on = threading.Event(), threading.Event()

    async def beside():
        held.set()
        go_on.wait()

    before = set(threading.enumerate())
    sockets = listening.listen("127.0.0.1", 0)
    served = Serving(app, sockets, tls=False, beside=beside)
    served.start()
    (http,) = set(threading.enumerate()) - before
    until(held.is_set, what="it is held up")
    served.stop()
    assert http.is_alive()
    assert all(one.fileno() >= 0 for one in sockets)
    go_on.set()
    until(lambda: not http.is_alive(), what="its end")
    assert all(one.fileno() < 0 for one in sockets)
