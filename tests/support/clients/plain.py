"""Drives a robot with nothing but zenoh and json: `plain.py ENDPOINT ROBOT ANGLE`, until killed or told to leave."""

import json
import select
import sys

import zenoh


def main(endpoint: str, robot: str, angle_deg: float) -> None:
    settings = {"mode": "client", "connect": {"endpoints": [endpoint]}, "scouting": {"multicast": {"enabled": False}}}
    with zenoh.open(zenoh.Config.from_json5(json.dumps(settings))) as session:
        command = {"power": 0.4, "angle_deg": angle_deg}
        lease = ""
        while not lease:
            for reply in session.get(f"{robot}/drive/command", payload=json.dumps(command)):
                lease = json.loads(reply.ok.payload.to_bytes()).get("lease", "") if reply.ok else ""
        print("driving", flush=True)
        while not select.select([sys.stdin], [], [], 0.1)[0]:
            session.put(f"{robot}/drive/command", json.dumps(command | {"lease": lease}))


if __name__ == "__main__":
    main(sys.argv[1], sys.argv[2], float(sys.argv[3]))
