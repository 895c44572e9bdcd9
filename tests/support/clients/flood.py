"""Floods a robot with nothing but zenoh: `flood.py ENDPOINT KEY COUNT [PAYLOAD]`, COUNT messages at once, pause, again,
until killed."""

import json
import sys
import time

import zenoh

PAYLOAD = json.dumps({"n": 0, "text": "x" * 200})
PAUSE_S = 0.2


def main(endpoint: str, key: str, count: int, payload: str = PAYLOAD) -> None:
    settings = {"mode": "client", "connect": {"endpoints": [endpoint]}, "scouting": {"multicast": {"enabled": False}}}
    with zenoh.open(zenoh.Config.from_json5(json.dumps(settings))) as session:
        publisher = session.declare_publisher(key)
        print("flooding", flush=True)
        while True:
            for _ in range(count):
                publisher.put(payload)
            time.sleep(PAUSE_S)


if __name__ == "__main__":
    main(sys.argv[1], sys.argv[2], int(sys.argv[3]), *sys.argv[4:])
