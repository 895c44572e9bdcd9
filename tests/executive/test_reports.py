"""Reports of a robot that has cameras and a package of its own: pictures are left alone, the rest is told."""

from types import SimpleNamespace
from typing import Any

import pytest

from lbr.apps.telemetry.kind import KIND as TELEMETRY
from lbr.bus import session, wire
from lbr.capability.config import OutputWire
from lbr.capability.kind import Kind
from lbr.drivers.camera import KIND as CAMERA
from lbr.executive.planning.plan import Plan
from lbr.executive.service.reports import Reports
from lbr.messages.camera import JpegFrame
from lbr.messages.telemetry import BatteryPart, Telemetry
from lbr.operations.drive import KIND as DRIVE

PACKAGE = Telemetry(
    time_s=1.7e9,
    battery=BatteryPart(age_s=0.2, voltage_v=12.6, charge=0.9, charging=False, source="battery", level="ok"),
)
KINDS: dict[str, Kind] = {"camera_front": CAMERA, "telemetry": TELEMETRY, "drive": DRIVE}
STATE = {"moving": False, "loop": {"rate_hz": 50.0}}


def unit(name: str, kind: Kind) -> Any:
    outputs = {output: (OutputWire(key=f"lbr/{name}/{output}"),) for output in kind.outputs}
    return SimpleNamespace(name=name, config=SimpleNamespace(outputs=outputs))


class Answering:
    """A robot's streams on a bus of their own; counts how often each picture was asked for."""

    def __init__(self, place: str) -> None:
        self.router = session.open_router(session.Router(listen=(place,)))
        self.bus = session.open_client([place])
        self.fetched = 0
        self.said = {"telemetry/package": PACKAGE, "drive/state": STATE}
        self.publishers = [wire.Publisher(self.router, f"lbr/{key}", "test") for key in self.said]
        for publisher, message in zip(self.publishers, self.said.values(), strict=True):
            publisher.put(message)
        self.picture = self.router.declare_queryable("lbr/camera_front/frame", wire.direct(self._fetch), complete=True)

    def _fetch(self, query: Any) -> None:
        self.fetched += 1
        with query:
            query.reply("lbr/camera_front/frame", JpegFrame(b"\xff\xd8\xff\xd9").data)

    def close(self) -> None:
        self.bus.close()
        self.router.close()


@pytest.fixture
def streams(tmp_path):
    answering = Answering(f"unixsock-stream/{tmp_path}/s.sock")
    yield answering
    answering.close()


@pytest.fixture
def reports(streams) -> Reports:
    plan = Plan(robot="lbr", units={name: unit(name, kind) for name, kind in KINDS.items()}, kinds=KINDS, rows=None)  # type: ignore[arg-type]
    status = SimpleNamespace(capabilities=())
    return Reports(SimpleNamespace(plan=plan, status=lambda: status), streams.bus)  # type: ignore[arg-type]


def test_telemetry_has_every_stream_that_speaks_and_fetches_no_picture(reports, streams):
    data, _ = reports.make("telemetry")
    assert sorted(data) == ["drive/state", "telemetry/package"]
    assert data["telemetry/package"]["battery"]["charge"] == 0.9
    assert data["drive/state"]["age_s"] < 5.0
    assert streams.fetched == 0


def test_telemetry_is_told_part_by_part(reports):
    _, text = reports.make("telemetry")
    lines = text.splitlines()
    assert lines[0].startswith("battery: voltage 12.6 V, charge 0.9")
    assert lines[0].endswith("(0.2 s old)")
    assert any(line.startswith("drive/state: moving no") for line in lines)
    assert not any("telemetry/package" in line for line in lines)


def test_statistics_ask_the_drive_alone(reports, streams):
    data, _ = reports.make("statistics")
    assert data == {"drive/loop": {"rate_hz": 50.0}}
    assert streams.fetched == 0
