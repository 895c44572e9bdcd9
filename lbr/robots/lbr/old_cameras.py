"""The table of cameras of this robot's first program, as in its API."""

import re
from collections.abc import Iterator, Mapping
from json import loads
from typing import Any, NamedTuple

from lbr.messages.rows import short
from lbr.robot.old_data import Choice, Here, Note, OldData, Source, Want, no_place

_CONTROL = re.compile(r"[A-Za-z][A-Za-z0-9_]{0,59}", re.ASCII)
_GROUPS = ("user", "camera")
"""The original's groups of a camera's controls, as in V4L2."""
_WRONG = {
    "white_balance_automatic": "the original set another control by this name",
    "exposure_dynamic_framerate": "the original never set it",
    "led1_mode": "the original never set it",
    "led1_frequency": "the original never set it",
}


class OldCameras(NamedTuple):
    """Cameras by their names: a device, whether it was on, and its controls."""

    cameras: Mapping[str, Mapping[str, Any]]

    def fits(self, target: Here) -> bool:
        """Return whether a robot has a camera mounted at the place of one of these."""
        return any(_mounted(target, name) for name in self.cameras)

    def wants(self, target: Here, choice: Choice) -> Iterator[Want | Note]:  # noqa: ARG002
        """Yield devices' addresses and cameras' controls."""
        for name, camera in self.cameras.items():
            yield from _camera(name, camera, target)


def read(source: Source) -> OldData | None:
    """Return the cameras of `GET /cameras`, or of a telemetry package; None for other content."""
    content = source.json
    content = content.get("cameras", content) if isinstance(content, dict) else None
    if not isinstance(content, dict) or not content:
        return None
    if not all(
        isinstance(one, dict) and isinstance(one.get("device"), str) and "status" in one for one in content.values()
    ):
        return None
    return OldCameras(content)


def _mounted(target: Here, mount: str) -> tuple[str, str] | None:
    """Return the device and the capability of the camera with that mount."""
    for device in target.rows("device"):
        if device["type"] == "camera" and loads(device["settings"]).get("mount") == mount:
            for row in target.rows("capability"):
                if row["kind"] == "camera" and loads(row["settings"]).get("device") == device["name"]:
                    return device["name"], row["name"]
    return None


def _camera(name: str, camera: Mapping[str, object], target: Here) -> Iterator[Want | Note]:
    row = short(name)
    mounted = _mounted(target, name)
    if not camera["device"]:
        yield no_place("cameras", row, "", "it is no camera, but how all were switched off: /camera/off")
        return
    if mounted is None:
        yield no_place("cameras", row, "device", "no camera of this robot is mounted there (device.settings, mount)")
        return
    device, capability = mounted
    yield Want("device", {"name": device}, {"address": camera["device"]}, f"cameras '{row}', device")
    yield no_place("cameras", row, "status", "the camera is chosen while the robot runs: /camera/NAME")
    controls = camera.get("settings") or {}
    if not isinstance(controls, dict):
        yield no_place("cameras", row, "settings", "it is no table of controls")
        return
    for control, where, value in _controls(controls):
        if not _CONTROL.fullmatch(control):
            yield no_place("cameras", row, "settings", f"'{short(control)}' is no name of a control")
        elif control in _WRONG or isinstance(value, bool) or not isinstance(value, int | float):
            text = _WRONG.get(control, f"'{short(value)}' is not a number")
            yield no_place("cameras", row, f"settings.{where}", text)
        else:
            yield Want(
                "capability",
                {"name": capability},
                {f"settings.controls.{control}": value},
                f"cameras '{row}', {control}",
            )


def _controls(controls: Mapping[str, object]) -> Iterator[tuple[str, str, object]]:
    """Yield each control: its name, its place, and its value; the original puts some in groups."""
    for name, value in controls.items():
        if name in _GROUPS and isinstance(value, dict):
            yield from ((inner, f"{name}.{short(inner)}", one) for inner, one in value.items())
        else:
            yield name, short(name), value
