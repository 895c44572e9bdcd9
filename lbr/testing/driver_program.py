"""The program that a test kills: runs a driver until then, with a bench as its argument in JSON; wheels turn
meanwhile."""

import importlib
import json
import sys
from pathlib import Path
from typing import Any

import msgspec

from lbr.capability import registry
from lbr.capability.context import Device
from lbr.messages.motors import MotorSetpoint
from lbr.testing.device import elsewhere
from lbr.testing.driver import DriverBench
from lbr.testing.driver_process import WORKS

STEP_S = 0.01


def main(bench_json: dict[str, Any]) -> None:
    """Run the driver, and report once that it works."""
    bench = DriverBench(
        registry.find(bench_json["kind"], Path(bench_json["home"])),
        bench_json["settings"],
        elsewhere(Device(**bench_json["device"])),
        wired={port: tuple(names) for port, names in bench_json["wired"].items()},
        given=tuple(
            msgspec.convert(row, getattr(importlib.import_module(module), name))
            for module, name, row in bench_json["given"]
        ),
    )
    turns = bench.kind.setpoints.get("setpoint") is MotorSetpoint
    bench.works()
    if turns:
        bench.drives(bench_json["powers"])
    print(WORKS, flush=True)
    while True:
        if turns:
            bench.drive(bench_json["powers"])
        bench.runs(STEP_S)


if __name__ == "__main__":
    main(json.loads(sys.argv[1]))
