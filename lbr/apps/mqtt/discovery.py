"""The discovery document for Home Assistant: one for the device and all its entities. Pure.

https://www.home-assistant.io/integrations/mqtt/#device-discovery-payload
"""

from collections.abc import Collection, Mapping

from lbr.apps.mqtt.words import LONGEST_TEXT, Word, bounds

ONLINE, OFFLINE = "online", "offline"
PRESSED = "PRESS"
ICONS = {"stop": "mdi:stop-circle", "run": "mdi:robot", "say": "mdi:bullhorn", "play": "mdi:human-greeting"}


def document(
    robot: str, name: str, topic: str, parts: Collection[str], words: Mapping[str, Word], *, picture: bool, version: str
) -> dict[str, object]:
    """Return the device, with a sensor for each reported value and a control for each of the row's words."""
    sensors: dict[str, dict[str, object]] = {key: _known(topic, **sensor) for key, sensor in _sensors(parts).items()}
    components = {
        **sensors,
        **{f"ask_{name_of_word}": _asking(name_of_word, word, topic) for name_of_word, word in words.items()},
    }
    components["answer"] = {
        "p": "sensor",
        "name": "Last answer",
        "icon": "mdi:message-reply-text",
        "state_topic": f"{topic}/answer",
        "value_template": "{{ (value_json.reason or value_json.state)[:250] }}",
    }
    if picture:
        components["camera"] = {"p": "camera", "name": "Camera", "topic": f"{topic}/picture"}
    return {
        "dev": {"ids": [f"lbr_{robot}"], "name": name or robot, "mf": "lbr", "mdl": robot, "sw": version},
        "o": {"name": "lbr", "sw": version},
        "availability": [{"topic": f"{topic}/available"}],
        "qos": 1,
        "cmps": {key: {"unique_id": f"lbr_{robot}_{key}", **component} for key, component in components.items()},
    }


def _sensors(parts: Collection[str]) -> dict[str, dict[str, str]]:
    by_part: dict[str, dict[str, dict[str, str]]] = {
        "battery": {
            "battery": _measured("Battery", "battery", "charge_percent", unit="%", device_class="battery"),
            "voltage": _measured("Battery voltage", "battery", "voltage_v", unit="V", device_class="voltage"),
        },
        "docked": {"docked": _binary("Docked", _value("docked"), device_class="plug")},
        "position": {
            "position_x": _measured("Position x", "position", "x_m", unit="m", device_class="distance"),
            "position_y": _measured("Position y", "position", "y_m", unit="m", device_class="distance"),
            "heading": _measured("Heading", "position", "heading_deg", unit="°", icon="mdi:compass"),
        },
        "motion": {"moving": _binary("Moving", _value("motion", "moving"), device_class="moving")},
        "behaviour": {
            "behaviour": {"name": "Behaviour", "value": _value("behaviour", "state"), "icon": "mdi:state-machine"}
        },
        "faults": {
            "fault": _binary("Fault", _value("faults"), device_class="problem"),
            "faults": {
                "name": "Faults",
                "value": _value("faults"),
                "template": "(v | join('; '))[:250] or 'none'",
                "icon": "mdi:alert",
            },
        },
    }
    return {key: sensor for part in parts for key, sensor in by_part[part].items()}


def _value(part: str, name: str = "") -> str:
    """Return the template expression of a value, which is null while the value or its part is missing."""
    whole = f"value_json.get('{part}')"
    return f"({whole} or {{}}).get('{name}')" if name else whole


def _measured(name: str, part: str, value: str, *, unit: str, **more: str) -> dict[str, str]:
    measure = {"unit_of_measurement": unit, "state_class": "measurement"}
    return {"name": name, "value": _value(part, value), **measure, **more}


def _binary(name: str, value: str, **more: str) -> dict[str, str]:
    return {"platform": "binary_sensor", "name": name, "value": value, "shown": "'ON' if v else 'OFF'", **more}


def _known(
    topic: str, *, name: str, value: str, template: str = "v", platform: str = "sensor", **more: str
) -> dict[str, object]:
    """Return a sensor that is available while the robot is online and the value is known."""
    state, read = f"{topic}/state", f"{{% set v = {value} %}}"
    is_known = {"topic": state, "value_template": f"{read}{{{{ '{OFFLINE}' if v is none else '{ONLINE}' }}}}"}
    return {
        "p": platform,
        "name": name,
        "state_topic": state,
        "value_template": f"{read}{{{{ 'None' if v is none else {template} }}}}",
        "availability": [{"topic": f"{topic}/available"}, is_known],
        "availability_mode": "all",
        **more,
    }


def _asking(word_name: str, word: Word, topic: str) -> dict[str, object]:
    """Return a button for a word without a value, else an input field."""
    name, wanted = word_name.replace("_", " ").capitalize(), bounds(word)
    component = {"name": name, "command_topic": f"{topic}/ask/{word_name}"}
    if wanted is None:
        kind = str(word.__struct_config__.tag)
        return {"p": "button", **component, "payload_press": PRESSED, "icon": ICONS.get(kind, "mdi:arrow-all")}
    if wanted.text:
        return {"p": "text", **component, "min": 1, "max": LONGEST_TEXT, "icon": ICONS["say"]}
    range_ = {"min": wanted.least, "max": wanted.most, "step": 1, "mode": "box", "unit_of_measurement": wanted.unit}
    return {"p": "number", **component, **range_}
