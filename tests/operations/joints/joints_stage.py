"""Real processes around two emulated servos: the joints operation, the servos' driver, and a bus between them."""

import json
import os
import select
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path

import msgspec

from lbr.bus import session, wire
from lbr.capability.config import DeviceConfig, InputWire, OutputWire, ProcessConfig
from lbr.capability.context import Device
from lbr.executive.planning.process_specs import ProcessSpec
from lbr.executive.processes.process_host import Child, ProcessHost
from lbr.executive.processes.reaper import Reaper
from lbr.messages.joints import Joint
from lbr.messages.rows import row_set
from lbr.simulation.devices.dynamixel.twin import DynamixelTwin
from lbr.simulation.twins.base import Surroundings
from tests.operations.joints.joints_bench import BODY, ROWS
from tests.support import programs
from tests.support.waiting import until

KEY = "5e" * 32
JOINTS = tuple(joint for joint in ROWS if joint.name in {"left_knee", "right_knee"})
HOLD_S, RELEASE_S = 1.0, 0.3
SERVOS = {
    "device": "servos",
    "hold_s": HOLD_S,
    "release_s": RELEASE_S,
    "setpoint_valid_s": 0.25,
    "guard": False,
    "reply_margin_s": 0.05,
}
JOINTS_SETTINGS = {"servos_max_age_s": 1.0}
"""Patient with a machine that is busy with other tests."""

CLIENT = """
import json, sys, time
from lbr.bus import session, wire
bus = session.open_client([sys.argv[1]])
def ask(message):
    answers = wire.ask(bus, "r/joints/command", message, source="client")
    return json.loads(answers[0].payload) if answers else {}
reply = ask({"positions": {"left_knee": float(sys.argv[2])}, "duration_s": 8.0, "ttl_s": 1.0})
while reply.get("accepted"):
    time.sleep(0.1)
    reply = ask({"lease": reply["lease"], "ttl_s": 1.0})
"""
"""Moves the left knee for eight seconds, and renews its lease as long as that is of use."""


class Twin:
    """The emulated bus, at work in a thread of the test."""

    def __init__(self, address: Path) -> None:
        ids = [joint.device_id for joint in JOINTS]
        device = Device(name="servos", type="dynamixel", address=str(address), settings={"ids": ids})
        self._twin = DynamixelTwin(device, Surroundings(seed=1, now=time.monotonic()))
        self._over = False
        self._twin.service(time.monotonic())
        self._thread = threading.Thread(target=self._work)
        self._thread.start()

    def joint(self, name):
        """Return where its servo is, where it is to go, both as angles of the joint, and its torque."""
        (servo,) = (servo for servo in self._twin.bus.servos if servo.id == BODY.joints[name].device_id)
        drive = servo.drive()
        here = BODY.joint_rad(name, servo.felt.position_rad)
        return here, BODY.joint_rad(name, drive.goal_rad), drive.torque

    def close(self):
        self._over = True
        self._thread.join()
        self._twin.close()

    def _work(self):
        while not self._over:
            watched, due = self._twin.watched(), self._twin.next_due()
            wait_s = 0.01 if due is None else min(0.01, max(0.0, due - time.monotonic()))
            select.select([watched] if watched is not None else [], [], [], wait_s)
            self._twin.service(time.monotonic())


class Stage:
    """A router, the twin, and the two processes; each may be killed, stopped and started over."""

    def __init__(self, home: Path) -> None:
        self.home = home
        self.twin = Twin(home / "tty")
        endpoint = f"unixsock-stream/{home}/bus.sock"
        self.endpoint = endpoint
        self.router = session.open_router(session.Router(listen=(endpoint,)))
        self.bus = session.open_client([endpoint])
        self.reaper = Reaper()
        self.processes = ProcessHost(home, self.reaper)
        self.children: dict[str, Child] = {}
        self.client: subprocess.Popen[bytes] | None = None
        self.start("servos")
        self.start("joints")
        until(lambda: self.state() and self.knee["torque"] is not None)

    def start(self, name):
        kind, settings, wiring, outputs = {
            "servos": (
                "dynamixel",
                SERVOS,
                {"setpoint": (InputWire(key="r/servos/setpoint", source="joints", seal=KEY, history=1),)},
                {"state": (OutputWire(key="r/servos/state", seal=KEY),)},
            ),
            "joints": (
                "joints",
                JOINTS_SETTINGS,
                {"servos": (InputWire(key="r/servos/state", source="servos", seal=KEY),)},
                {
                    "setpoint": (OutputWire(key="r/servos/setpoint", seal=KEY),),
                    "state": (OutputWire(key="r/joints/state"),),
                    "result": (OutputWire(key="r/joints/result"),),
                },
            ),
        }[name]
        devices = (DeviceConfig(name="servos", type="dynamixel", address=str(self.home / "tty")),)
        config = ProcessConfig(
            robot="r",
            name=name,
            kind=kind,
            settings=msgspec.Raw(json.dumps(settings).encode()),
            endpoints=(self.endpoint,),
            home=str(self.home),
            device="servos" if name == "servos" else "",
            devices=devices if name == "servos" else (),
            wiring=wiring,
            outputs=outputs,
            requests={"servos_recover": {"servos": "r/servos/recover"}} if name == "joints" else {},
            rows={"joint": row_set(Joint, JOINTS)},
            release_key=KEY,
        )
        family = "driver" if name == "servos" else "operation"
        unit = ProcessSpec(name=name, kind=kind, family=family, moves=True, restart="never", needs=(), config=config)
        self.children[name] = self.processes.start(unit, config)

    def ask(self, key, message=None):
        answers = wire.ask(self.bus, f"r/{key}", message, source="test")
        return json.loads(answers[0].payload) if answers else None

    def state(self):
        return self.ask("joints/state")

    @property
    def knee(self):
        return self.state()["joints"]["left_knee"]

    def log(self, name):
        return (self.home / f"r-{name}.log").read_text()

    def stand(self):
        """Give every joint torque, and have a client of its own move the left knee slowly; wait until it moves."""
        until(lambda: self._moves() or self.dismiss(), what="a motion that goes on")

    def _moves(self):
        self.ask("joints/torque", {"on": True})
        if self.state()["phase"] != "following":
            return False
        before = self.twin.joint("left_knee")[1]
        target = -1.9 if before > -1.0 else 0.0
        self.client = programs.start([sys.executable, "-c", CLIENT, self.endpoint, str(target)])
        until(lambda: self.client.poll() is not None or abs(self.twin.joint("left_knee")[1] - before) > 0.03)
        return self.client.poll() is None

    def dismiss(self):
        """Kill the client, if there is one."""
        if self.client is not None:
            self.client.kill()
            self.client.wait()
            self.client = None

    def heard(self, key, **wanted):
        """Wait until a state says all this, and return it."""
        return until(lambda: (seen := self.ask(key)) and all(seen[n] == w for n, w in wanted.items()) and seen)

    def kill(self, name, number=signal.SIGKILL):
        os.killpg(self.children[name].pid, number)

    def reap(self, name):
        child = self.children.pop(name)
        until(lambda: [child.reports(), child.returncode()][-1] is not None)
        child.close()

    def close(self):
        self.dismiss()
        for name in list(self.children):
            self.kill(name, signal.SIGCONT)
            self.kill(name)
            self.reap(name)
        self.reaper.close()
        self.bus.close()
        self.router.close()
        self.twin.close()
