"""Messages that wake nobody wait within the bus library, the newest only."""

import json
from pathlib import Path

from lbr.bus import session, wire
from tests.support.waiting import until


def test_what_nobody_is_woken_for_waits_newest_only_oldest_first(tmp_path: Path):
    endpoint = f"unixsock-stream/{tmp_path}/r.sock"
    with session.open_router(session.Router(listen=(endpoint,))) as router:
        stream = wire.Publisher(router, "robot/imu/sample", "imu")
        with session.open_client([endpoint]) as client:
            waiting = wire.PolledSubscription(client, "robot/imu/sample", depth=3)
            assert waiting.take() == []
            heard = until(lambda: stream.put({"n": 0}) and waiting.take(), what="a first message")
            assert heard[-1].payload == b'{"n":0}'
            end = wire.Subscription(client, "robot/end", depth=1)
            for number in range(1, 8):
                stream.put({"n": number})
            until(lambda: router.put("robot/end", "{}") or end.take(), what="what came after them")
            assert [message.payload for message in waiting.take()] == [b'{"n":5}', b'{"n":6}', b'{"n":7}']
            assert waiting.take() == []


def test_a_latest_value_is_renewed_when_it_is_asked_for(tmp_path: Path):
    endpoint = f"unixsock-stream/{tmp_path}/r.sock"
    engaged = [False]
    with session.open_router(session.Router(listen=(endpoint,))) as router:
        stream = wire.Publisher(
            router, "robot/@status", "executive", renew=lambda said: {**said, "engaged": engaged[0]}
        )
        assert wire.ask(router, "robot/@status", None, source="test") == []
        stream.put({"engaged": False, "ready": True})
        for engaged[0] in (True, False):
            told = wire.ask(router, "robot/@status", None, source="test")
            assert [json.loads(one.payload) for one in told] == [{"engaged": engaged[0], "ready": True}]
