"""Messages read and written by rclpy: a line of JSON in, `{"type": …, "hex": …}`, and one out.

What comes out is the hash of the type, the fields as they are read, and the same message as rclpy writes it.
"""

import array
import importlib
import importlib.util
import json
import sys
from pathlib import Path

import numpy as np
from rclpy.serialization import deserialize_message, serialize_message

SHARE = Path(sys.prefix) / "share"


def fields(value: object) -> object:
    if hasattr(value, "get_fields_and_field_types"):
        return {name: fields(getattr(value, name)) for name in value.get_fields_and_field_types()}
    if isinstance(value, list | tuple | array.array | np.ndarray):
        return [fields(one) for one in value]
    if isinstance(value, bytes):
        return value[0]
    return value.item() if isinstance(value, np.generic) else value


def hash_of(type_: str) -> str:
    package, kind, name = type_.split("/")
    described = json.loads((SHARE / package / kind / f"{name}.json").read_text())
    return next(one["hash_string"] for one in described["type_hashes"] if one["type_name"] == type_)


def main() -> None:
    for line in sys.stdin:
        asked = json.loads(line)
        package, kind, name = asked["type"].split("/")
        if importlib.util.find_spec(package) is None:
            print(json.dumps({"absent": package}), flush=True)
            continue
        found = {"hash": hash_of(asked["type"])}
        if kind == "srv":
            type_ = getattr(getattr(importlib.import_module(f"{package}.srv"), name), asked["part"])
        else:
            type_ = getattr(importlib.import_module(f"{package}.msg"), name)
        message = deserialize_message(bytes.fromhex(asked["hex"]), type_)
        print(json.dumps(found | {"fields": fields(message), "hex": serialize_message(message).hex()}), flush=True)


if __name__ == "__main__":
    main()
