"""The service of device shadows as AWS documents it, for tests: on a plain broker, by what is said on its topics.

https://docs.aws.amazon.com/iot/latest/developerguide/device-shadow-document.html
"""

import copy
import json
import threading
import time
from typing import Any

from tests.support.mosquitto import Mosquitto, Person

HOUR_S = 3600


class ShadowService(Person):
    """One shadow. `aged_s` is added to how old what is desired is said to be; `updates` are the bodies of all updates."""

    def __init__(self, broker: Mosquitto, name: str, thing: str) -> None:
        self.root = f"$aws/things/{thing}/shadow"
        self.version = 0
        self.state: dict[str, Any] = {"desired": {}, "reported": {}}
        self.stamps: dict[str, Any] = {"desired": {}, "reported": {}}
        self.updates: list[dict[str, Any]] = []
        self.at: list[float] = []
        self._lock = threading.Lock()
        super().__init__(broker, name, f"{self.root}/get", f"{self.root}/update")
        self.hear = self._serve

    def desire(self, *, age_s: float = 0.0, **desired: Any) -> None:
        """Have somebody else write what is desired."""
        with self._lock:
            self._merge("desired", desired, time.time() - age_s)
            self.version += 1
            self._tell_delta()

    def _serve(self, topic: str, payload: bytes) -> None:
        with self._lock:
            said = json.loads(payload)
            token = {"clientToken": said["clientToken"]} if "clientToken" in said else {}
            if topic.endswith("/get"):
                self._got(token)
            else:
                self._updated(said, token)

    def _got(self, token: dict[str, str]) -> None:
        if self.version == 0:
            self._say("get/rejected", {"code": 404, "message": "No shadow exists with this name", **token})
            return
        told = {"state": self.state | {"delta": self._delta()}, "metadata": self.stamps, "version": self.version}
        self._say("get/accepted", {**told, "timestamp": int(time.time()), **token})

    def _updated(self, said: dict[str, Any], token: dict[str, str]) -> None:
        self.updates.append(said)
        self.at.append(time.monotonic())
        if said.get("version", self.version) != self.version:
            self._say("update/rejected", {"code": 409, "message": "Version conflict", **token})
            return
        for part, change in said["state"].items():
            self._merge(part, change or {}, time.time())
        self.version += 1
        self._say("update/accepted", {"state": said["state"], "version": self.version, **token})
        self._tell_delta()

    def _tell_delta(self) -> None:
        if delta := self._delta():
            self._say("update/delta", {"state": delta, "version": self.version, "timestamp": int(time.time())})

    def _merge(self, part: str, change: dict[str, Any], at: float) -> None:
        for key, value in change.items():
            self.state[part][key] = _merged(self.state[part].get(key), value)
            self.stamps[part][key] = {"timestamp": int(at)}
            if value is None:
                del self.state[part][key], self.stamps[part][key]

    def _delta(self) -> dict[str, Any]:
        return _difference(self.state["desired"], self.state["reported"])

    def _say(self, topic: str, body: dict[str, Any]) -> None:
        self.client.publish(f"{self.root}/{topic}", json.dumps(body), qos=1)


def _merged(old: Any, new: Any) -> Any:
    if not isinstance(new, dict):
        return new
    found = copy.deepcopy(old) if isinstance(old, dict) else {}
    for key, value in new.items():
        if value is None:
            found.pop(key, None)
        else:
            found[key] = _merged(found.get(key), value)
    return found


def _difference(desired: dict[str, Any], reported: dict[str, Any]) -> dict[str, Any]:
    """Of objects, what differs alone; as the service does it."""
    found = {}
    for key, value in desired.items():
        old = reported.get(key)
        if isinstance(value, dict) and isinstance(old, dict):
            if inner := _difference(value, old):
                found[key] = inner
        elif value != old:
            found[key] = value
    return found
