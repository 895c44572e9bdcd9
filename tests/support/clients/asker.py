"""Asks more than it listens to: `asker.py ENDPOINT KEY` asks as fast as it can, until it is killed."""

import json
import sys

import zenoh


def main(endpoint: str, key: str) -> None:
    settings = {"mode": "client", "connect": {"endpoints": [endpoint]}, "scouting": {"multicast": {"enabled": False}}}
    with zenoh.open(zenoh.Config.from_json5(json.dumps(settings))) as session:
        print("asking", flush=True)
        while True:
            session.get(key, lambda _reply: None, payload=b"status", timeout=2.0)


if __name__ == "__main__":
    main(*sys.argv[1:])
