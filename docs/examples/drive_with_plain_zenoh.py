"""Drive the robot with nothing but Zenoh: python drive_with_plain_zenoh.py ENDPOINT [SECONDS] [ROBOT]

ENDPOINT is where the robot listens, such as tcp/192.168.1.7:7447, or an endpoint of the ready line of
`lbr run --no-console`. It asks for a motion, keeps it alive by repeating it ten times a second with its lease, reads
the ranges meanwhile, and stops. Kill it at any moment: the lease lapses, and the robot stops by itself.
"""

import json
import sys
import time

import zenoh


def ask(session: zenoh.Session, key: str, message: dict) -> dict:
    """Query a key with a JSON message and return the answer."""
    for reply in session.get(key, payload=json.dumps(message), encoding="application/json", timeout=2.0):
        if reply.ok is not None:
            return json.loads(reply.ok.payload.to_bytes())
    sys.exit(f"nobody answers on {key}")


def main(endpoint: str, seconds: float = 2.0, robot: str = "lbr") -> None:
    """Drive ahead slowly for some seconds."""
    config = zenoh.Config()
    config.insert_json5("mode", '"client"')
    config.insert_json5("connect/endpoints", json.dumps([endpoint]))
    config.insert_json5("scouting/multicast/enabled", "false")
    with zenoh.open(config) as session:
        answer = ask(session, f"{robot}/drive/command", {"power": 0.2, "angle_deg": 0})
        if not answer["accepted"]:
            sys.exit(f"refused: {answer['reason']}")
        print(f"accepted, lease {answer['lease']} of {answer['ttl_s']} s", flush=True)
        renewal = json.dumps({"power": 0.2, "angle_deg": 0, "lease": answer["lease"]})
        ranges = session.declare_subscriber(f"{robot}/ranges/readings", zenoh.handlers.RingChannel(1))
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            session.put(f"{robot}/drive/command", renewal, encoding="application/json")
            reading = ranges.try_recv()
            if reading is not None:
                print(f"forward {json.loads(reading.payload.to_bytes())['forward_m']} m", flush=True)
            time.sleep(0.1)
        print("stopped" if ask(session, f"{robot}/drive/stop", {})["accepted"] else "not stopped")


if __name__ == "__main__":
    if len(sys.argv) < 2:
        sys.exit(__doc__)
    main(sys.argv[1], *(float(text) for text in sys.argv[2:3]), *sys.argv[3:4])
