"""A client with nothing but Zenoh: python at_a_door.py CONFIG.json5 MANNER; prints a line for each answer.

`quoting` repeats its command with its lease, `stamped` does so with the time of a clock of its own, `careless` repeats
without any lease, and `asking` asks again each time. Each line on standard input switches: `cease`, `go`.
"""

import json
import sys
import threading
import time

import zenoh

PERIOD_S = 0.05
AHEAD_S = 1234.5


class Client:
    def __init__(self, config: str, manner: str, robot: str = "lbr") -> None:
        self.session = zenoh.open(zenoh.Config.from_file(config))
        self.manner, self.robot, self.sequence, self.lease = manner, robot, 0, ""
        self.sending = True

    def stamp(self) -> dict:
        self.sequence += 1
        if self.manner != "stamped":
            return {}
        now = time.monotonic_ns() + int(AHEAD_S * 1e9)
        said = {"source": "plain", "seq": self.sequence, "mono_ns": now, "wall_ns": 0, "boot": "afar"}
        return {"attachment": json.dumps(said)}

    def ask(self) -> dict:
        command = json.dumps({"power": 0.1, "angle_deg": 90})
        for reply in self.session.get(f"{self.robot}/drive/command", payload=command, timeout=1.0, **self.stamp()):
            if reply.ok is not None:
                return json.loads(reply.ok.payload.to_bytes())
        return {"accepted": False, "reason": "nobody answers"}

    def step(self) -> None:
        if self.manner == "asking" or (self.manner != "careless" and not self.lease):
            answer = self.ask()
            print(json.dumps(answer), flush=True)
            self.lease = answer.get("lease", "")
        command = {"power": 0.1, "angle_deg": 90} | ({"lease": self.lease} if self.manner != "careless" else {})
        self.session.put(f"{self.robot}/drive/command", json.dumps(command), **self.stamp())

    def listen(self) -> None:
        for line in sys.stdin:
            self.sending = line.strip() != "cease"
            print(json.dumps({"heard": line.strip()}), flush=True)


def main() -> None:
    client = Client(*sys.argv[1:3])
    threading.Thread(target=client.listen, daemon=True).start()
    while True:
        if client.sending:
            client.step()
        time.sleep(PERIOD_S)


if __name__ == "__main__":
    main()
