"""A program as a capability, without the package lbr: it publishes how near the nearest thing is, about 5 times a second.

Its row is of kind `exec`; see proximity.sql. The executive tells it its wiring in the environment.
"""

import json
import os
import time

import zenoh

config = zenoh.Config.from_file(os.environ["LBR_CONFIG"])  # where the robot is, and who we are to it
ranges_keys = json.loads(os.environ["LBR_INPUTS"])["ranges"]
nearest_key = json.loads(os.environ["LBR_OUTPUTS"])["nearest"]

with zenoh.open(config) as session:
    ranges = session.declare_subscriber(ranges_keys[0], zenoh.handlers.RingChannel(1))
    alive = session.liveliness().declare_token(os.environ["LBR_ALIVE"])  # from now on it counts as ready
    while True:
        reading = json.loads(ranges.recv().payload.to_bytes())
        named = reading | {f"{name}_m": value for name, value in reading.get("others_m", {}).items()}
        seen = [value for key, value in named.items() if key.endswith("_m") and isinstance(value, float | int)]
        nearest = {"nearest_m": min(seen, default=None)}
        session.put(nearest_key, json.dumps(nearest), encoding="application/json")
        time.sleep(0.2)
