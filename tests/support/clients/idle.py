"""A process with a zenoh session and nothing else: `idle.py router|client ENDPOINT`, until its input ends."""

import json
import sys

import zenoh


def main(mode: str, endpoint: str) -> None:
    meet = {"listen": {"endpoints": [endpoint]}} if mode == "router" else {"connect": {"endpoints": [endpoint]}}
    scouting = {"multicast": {"enabled": False}, "gossip": {"enabled": False}}
    settings = {"mode": mode, "scouting": scouting, "transport": {"shared_memory": {"enabled": False}}} | meet
    with zenoh.open(zenoh.Config.from_json5(json.dumps(settings))):
        print("ready", flush=True)
        sys.stdin.read()


if __name__ == "__main__":
    main(sys.argv[1], sys.argv[2])
