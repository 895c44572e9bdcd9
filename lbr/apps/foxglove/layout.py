"""A layout of Foxglove for a robot: its body, cameras, numbers, events, a stick and a stop, as far as it has them.

Pure.
"""

from collections.abc import Iterable, Mapping, Sequence

from lbr.apps.foxglove.channels import LOG, MODEL, Source
from lbr.apps.foxglove.scene import BASE, WORLD
from lbr.apps.foxglove.services import Service

_NUMBERS = {
    "DriveState": ("left", "right"),
    "BatteryState": ("voltage_v",),
    "PowerState": ("voltage_v",),
    "AttitudeState": ("roll_rad", "pitch_rad"),
}
"""The fields to plot, by stream type."""
_MOST_CAMERAS = 3


def layout(sources: Iterable[Source], services: Iterable[Service], *, drives: bool) -> dict[str, object]:
    """Return a layout in Foxglove's import format."""
    by_topic = {source.channel.topic: source for source in sources}
    shapes = [topic for topic, source in by_topic.items() if source.channel.schema_name in _IN_SPACE]
    panels: dict[str, dict[str, object]] = {}
    cameras = [topic for topic, source in sorted(by_topic.items()) if source.picture][:_MOST_CAMERAS]
    for number, topic in enumerate(cameras, start=1):
        panels[f"Image!camera{number}"] = {"imageMode": {"imageTopic": topic}, "foxglovePanelTitle": topic}
    if shapes:
        panels["3D!body"] = {
            "followTf": BASE if MODEL in by_topic else WORLD,
            "followMode": "follow-pose",
            "topics": {topic: {"visible": True} for topic in sorted(shapes)},
            "layers": {"grid": {"layerId": "foxglove.Grid", "instanceId": "grid", "frameId": WORLD, "visible": True}},
        }
    if paths := _paths(by_topic):
        panels["Plot!numbers"] = {"paths": paths, "followingViewWidth": 30, "showLegend": True, "xAxisVal": "timestamp"}
    panels["RosOut!events"] = {"topicToRender": LOG, "minLogLevel": 2}
    if drives:
        panels["Teleop!stick"] = _stick()
    if any(service.word == "stop" for service in services):
        panels["CallService!stop"] = {
            "serviceName": "/stop",
            "requestPayload": "{}",
            "layout": "vertical",
            "buttonText": "Stop",
            "buttonColor": "#c62828",
            "foxglovePanelTitle": "Stop",
        }
    return {
        "configById": panels,
        "globalVariables": {},
        "userNodes": {},
        "playbackConfig": {"speed": 1},
        "layout": _tiled(list(panels), "row"),
    }


_IN_SPACE = {"foxglove.SceneUpdate", "foxglove.PoseInFrame", "foxglove.LaserScan"}


def _paths(known: Mapping[str, Source]) -> list[dict[str, object]]:
    return [
        {"value": f"{topic}.{field}", "enabled": True, "timestampMethod": "receiveTime"}
        for topic, one in sorted(known.items())
        for field in _NUMBERS.get(one.channel.schema_name, ())
    ]


def _stick() -> dict[str, object]:
    """Return a Teleop panel. It publishes at 10 Hz, since motion that is not renewed for 0.25 s ends."""
    return {
        "topic": "/cmd_vel",
        "publishRate": 10,
        "autoSendStopOnRelease": True,
        "upButton": {"field": "linear-x", "value": 0.2},
        "downButton": {"field": "linear-x", "value": -0.2},
        "leftButton": {"field": "angular-z", "value": 0.8},
        "rightButton": {"field": "angular-z", "value": -0.8},
    }


def _tiled(panels: Sequence[str], direction: str) -> object:
    if len(panels) == 1:
        return panels[0]
    half = (len(panels) + 1) // 2
    other = "column" if direction == "row" else "row"
    return {"first": _tiled(panels[:half], other), "second": _tiled(panels[half:], other), "direction": direction}
