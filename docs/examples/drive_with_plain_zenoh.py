"""Drive the robot with nothing but Zenoh: python drive_with_plain_zenoh.py [WHERE] [SECONDS] [ROBOT]

WHERE is a file that `lbr token add phone --file phone.json5` wrote, for a robot on another machine, or an endpoint of
the ready line of `lbr run --no-console`; without it, the robot that runs on this machine is meant. It asks for a motion,
keeps it alive by repeating it ten times a second with its lease, reads the ranges meanwhile, and stops. Kill it at any
moment: the lease lapses, and the robot stops by itself.
"""

import json
import os
import sys
import time
from pathlib import Path

import zenoh


def ask(session: zenoh.Session, key: str, message: dict) -> dict:
    """Query a key with a JSON message and return the answer."""
    for reply in session.get(key, payload=json.dumps(message), encoding="application/json", timeout=2.0):
        if reply.ok is not None:
            return json.loads(reply.ok.payload.to_bytes())
    sys.exit(f"nobody answers on {key}")


def robot_here() -> tuple[str, str]:
    """Return where the robot of this machine listens and its name: it says so in a file of its home while it runs."""
    home = Path(os.environ.get("LBR_HOME") or Path.home() / ".lbr")
    for record in sorted((home / "run").glob("*.json")):
        found = json.loads(record.read_text())
        if Path(f"/proc/{found['pid']}").exists():
            return found["endpoints"][0], found["robot"]
    sys.exit(f"no robot runs here ({home / 'run'} names none); 'lbr run' starts one, or name its endpoint")


def configuration(where: str) -> zenoh.Config:
    """Return what is in a file, or what leads to an endpoint of this machine."""
    if where.endswith(".json5"):
        return zenoh.Config.from_file(where)
    config = zenoh.Config()
    config.insert_json5("mode", '"client"')
    config.insert_json5("connect/endpoints", json.dumps([where]))
    config.insert_json5("scouting/multicast/enabled", "false")
    return config


def connected(where: str) -> zenoh.Session:
    """Open a session to a robot, or end with one sentence."""
    try:
        return zenoh.open(configuration(where))
    except zenoh.ZError:
        sys.exit(f"no robot can be reached at '{where}'; name a file of 'lbr token add --file', or a local endpoint")


def main(where: str, seconds: float = 2.0, robot: str = "lbr") -> None:
    """Drive ahead slowly for some seconds."""
    with connected(where) as session:
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
    given = sys.argv[1:]
    place, name = (given[0], "lbr") if given else robot_here()
    main(place, float(given[1]) if len(given) > 1 else 2.0, given[2] if len(given) > 2 else name)
