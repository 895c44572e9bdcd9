"""Sends every message back, with nothing but zenoh: `echo.py ENDPOINT`, until its input ends."""

import json
import sys

import zenoh


def main(endpoint: str) -> None:
    settings = {
        "mode": "client",
        "connect": {"endpoints": [endpoint]},
        "scouting": {"multicast": {"enabled": False}, "gossip": {"enabled": False}},
        "transport": {"shared_memory": {"enabled": False}},
    }
    with zenoh.open(zenoh.Config.from_json5(json.dumps(settings))) as session:
        back = session.declare_publisher("bench/pong", encoding=zenoh.Encoding.APPLICATION_JSON)

        def send_back(sample: zenoh.Sample) -> None:
            back.put(sample.payload, attachment=sample.attachment)

        session.declare_subscriber("bench/ping", zenoh.handlers.Callback(send_back, indirect=False))
        print("ready", flush=True)
        sys.stdin.read()


if __name__ == "__main__":
    main(sys.argv[1])
