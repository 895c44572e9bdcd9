"""What Home Assistant is told, so that it finds the robot by itself: one document for the device and all that it has. Pure.

https://www.home-assistant.io/integrations/mqtt/#device-discovery-payload
"""

from collections.abc import Collection, Mapping
from typing import Any

from lbr.apps.mqtt.words import LONGEST_TEXT, Word, bounds

ONLINE, OFFLINE = "online", "offline"
PRESSED = "PRESS"
ICONS = {"stop": "mdi:stop-circle", "run": "mdi:robot", "say": "mdi:bullhorn", "play": "mdi:human-greeting"}


def document(
    robot: str, name: str, topic: str, parts: Collection[str], words: Mapping[str, Word], *, picture: bool, version: str
) -> dict[str, Any]:
    """Return the device with its sensors, for the parts that are reported, and its buttons, for the words of its row."""
    state = {"state_topic": f"{topic}/state"}
    sensors = {key: state | one for key, one in _sensors(parts).items()}
    components = {**sensors, **{f"ask_{said}": _asking(said, word, topic) for said, word in words.items()}}
    components["answer"] = _sensor("Last answer", "answer", icon="mdi:message-reply-text") | {
        "state_topic": f"{topic}/answer",
        "value_template": "{{ (value_json.reason or value_json.state)[:250] }}",
    }
    if picture:
        components["camera"] = {"p": "camera", "name": "Camera", "topic": f"{topic}/picture"}
    return {
        "dev": {"ids": [f"lbr_{robot}"], "name": name or robot, "mf": "lbr", "mdl": robot, "sw": version},
        "o": {"name": "lbr", "sw": version},
        "availability_topic": f"{topic}/available",
        "qos": 1,
        "cmps": {key: {"unique_id": f"lbr_{robot}_{key}", **one} for key, one in components.items()},
    }


def _sensors(parts: Collection[str]) -> dict[str, dict[str, Any]]:
    found: dict[str, dict[str, dict[str, Any]]] = {
        "battery": {
            "battery": _sensor("Battery", "charge_percent", of="battery", unit="%", kind="battery"),
            "voltage": _sensor("Battery voltage", "voltage_v", of="battery", unit="V", kind="voltage"),
        },
        "docked": {"docked": _binary("Docked", "value_json.docked", kind="plug")},
        "position": {
            "position_x": _sensor("Position x", "x_m", of="position", unit="m", kind="distance"),
            "position_y": _sensor("Position y", "y_m", of="position", unit="m", kind="distance"),
            "heading": _sensor("Heading", "heading_deg", of="position", unit="°", icon="mdi:compass"),
        },
        "motion": {"moving": _binary("Moving", "(value_json.motion or {}).get('moving')", kind="moving")},
        "behaviour": {"behaviour": _sensor("Behaviour", "state", of="behaviour", icon="mdi:state-machine")},
        "faults": {
            "fault": _binary("Fault", "(value_json.faults or []) | length > 0", kind="problem"),
            "faults": _sensor("Faults", "faults", icon="mdi:alert")
            | {"value_template": "{{ ((value_json.faults or []) | join('; '))[:250] or 'none' }}"},
        },
    }
    return {key: one for part in parts for key, one in found[part].items()}


def _sensor(name: str, value: str, *, of: str = "", unit: str = "", kind: str = "", icon: str = "") -> dict[str, Any]:
    where = f"(value_json.{of} or {{}}).get('{value}')" if of else f"value_json.{value}"
    said = {"unit_of_measurement": unit, "device_class": kind, "icon": icon}
    measured = {"state_class": "measurement"} if unit else {}
    return (
        {"p": "sensor", "name": name, "value_template": f"{{{{ {where} }}}}"}
        | {k: v for k, v in said.items() if v}
        | measured
    )


def _binary(name: str, value: str, *, kind: str) -> dict[str, Any]:
    template = f"{{% set v = {value} %}}{{{{ 'None' if v is none else 'ON' if v else 'OFF' }}}}"
    return {"p": "binary_sensor", "name": name, "device_class": kind, "value_template": template}


def _asking(said: str, word: Word, topic: str) -> dict[str, Any]:
    """Return a button for a word that stands alone, and a field for one with which something comes."""
    name, wanted = said.replace("_", " ").capitalize(), bounds(word)
    found = {"name": name, "command_topic": f"{topic}/ask/{said}"}
    if wanted is None:
        kind = str(word.__struct_config__.tag)
        return {"p": "button", **found, "payload_press": PRESSED, "icon": ICONS.get(kind, "mdi:arrow-all")}
    if wanted.text:
        return {"p": "text", **found, "min": 1, "max": LONGEST_TEXT, "icon": ICONS["say"]}
    range_ = {"min": wanted.least, "max": wanted.most, "step": 1, "mode": "box", "unit_of_measurement": wanted.unit}
    return {"p": "number", **found, **range_}
