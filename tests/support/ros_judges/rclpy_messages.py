"""Messages read and written by rclpy: a line of JSON in, `{"type": …, "hex": …}`, and one out.

What comes out is the hash of the type, the fields as they are read, and the same message as rclpy writes it. With
`{"type": …, "many": [FIELD, TYPE]}` it is the hash of a type that rclpy's registry has not, one field of many of a type that
it has, by the rule of REP 2016 and rclpy's own descriptions.
"""

import array
import hashlib
import importlib
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


def described(type_: str) -> dict:
    package, kind, name = type_.split("/")
    return json.loads((SHARE / package / kind / f"{name}.json").read_text())


def hash_of(type_: str) -> str:
    return next(one["hash_string"] for one in described(type_)["type_hashes"] if one["type_name"] == type_)


def hash_of_many(type_: str, field: str, inside: str) -> str:
    found = described(inside)["type_description_msg"]
    assert by_rule(found) == hash_of(inside), "the rule is another"
    many = {"type_id": 145, "capacity": 0, "string_capacity": 0, "nested_type_name": inside}
    own = {"type_name": type_, "fields": [{"name": field, "type": many}]}
    others = [found["type_description"], *found["referenced_type_descriptions"]]
    ordered = sorted(others, key=lambda one: one["type_name"])
    return by_rule({"type_description": own, "referenced_type_descriptions": ordered})


def by_rule(description: dict) -> str:
    for one in (description["type_description"], *description["referenced_type_descriptions"]):
        for field in one["fields"]:
            field.pop("default_value", None)
    return f"RIHS01_{hashlib.sha256(json.dumps(description).encode()).hexdigest()}"


def main() -> None:
    for line in sys.stdin:
        asked = json.loads(line)
        if "many" in asked:
            print(json.dumps({"hash": hash_of_many(asked["type"], *asked["many"])}), flush=True)
            continue
        package, kind, name = asked["type"].split("/")
        found = {"hash": hash_of(asked["type"])}
        if kind == "srv":
            type_ = getattr(getattr(importlib.import_module(f"{package}.srv"), name), asked["part"])
        else:
            type_ = getattr(importlib.import_module(f"{package}.msg"), name)
        message = deserialize_message(bytes.fromhex(asked["hex"]), type_)
        print(json.dumps(found | {"fields": fields(message), "hex": serialize_message(message).hex()}), flush=True)


if __name__ == "__main__":
    main()
