"""Listens to everything, slowly: `listener.py ENDPOINT ROBOT SECONDS` takes one message each this many seconds."""

import json
import sys
import time

import zenoh


def main(endpoint: str, robot: str, pause_s: float) -> None:
    settings = {"mode": "client", "connect": {"endpoints": [endpoint]}, "scouting": {"multicast": {"enabled": False}}}
    with zenoh.open(zenoh.Config.from_json5(json.dumps(settings))) as session:
        handlers = [
            session.declare_subscriber(key, lambda _sample: time.sleep(pause_s))
            for key in (f"{robot}/**", f"{robot}/@status", f"{robot}/@event", f"{robot}/@estop/**")
        ]
        print("listening", flush=True)
        while handlers:
            time.sleep(1.0)


if __name__ == "__main__":
    main(sys.argv[1], sys.argv[2], float(sys.argv[3]))
