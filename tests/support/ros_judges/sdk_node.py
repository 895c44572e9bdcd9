"""A node by zenoh-ros2-sdk, as `pyzeros_node` in what it reads and writes: `sdk_node.py ENDPOINT`."""

import json
import select
import sys
import time

from rosbags.typesys import Stores, get_typestore
from zenoh_ros2_sdk import ROS2Publisher, ROS2ServiceClient, ROS2Subscriber

TRIGGER = "RIHS01_eeff2cd6fa5ad9d27cdf4dec64818317839b62f212a91e6b5304b634b2062c5f"
TYPES = get_typestore(Stores.ROS2_JAZZY)
"""By their text, as it would else fetch them from GitHub."""


def tell(**said: object) -> None:
    print(json.dumps(said), flush=True)


def typed(type_: str) -> dict[str, str]:
    text, _ = TYPES.generate_msgdef(type_, ros_version=2)
    return {"msg_type": type_, "msg_definition": text, "type_hash": TYPES.hash_rihs01(type_)}


def hear(message) -> None:
    stamp = message.header.stamp
    x, vx = message.pose.pose.position.x, message.twist.twist.linear.x
    tell(odom=[x, vx], age_s=time.time() - stamp.sec - stamp.nanosec / 1e9)


def main(endpoint: str) -> None:
    host, _, port = endpoint.partition("/")[2].rpartition(":")
    router = {"router_ip": host, "router_port": int(port)}
    publisher = ROS2Publisher("/cmd_vel", **typed("geometry_msgs/msg/Twist"), **router)
    subscriber = ROS2Subscriber("/odom", callback=hear, **typed("nav_msgs/msg/Odometry"), **router)
    vector = publisher.session_mgr.store.types["geometry_msgs/msg/Vector3"]
    wanted: list[float] | None = None
    tell(ready=True)
    while True:
        if select.select([sys.stdin], [], [], 0.05)[0]:
            asked = json.loads(sys.stdin.readline() or "null")
            if "twist" in asked:
                wanted = asked["twist"]
                tell(sent_ns=time.monotonic_ns())
            if "call" in asked:
                texts = {"request_definition": "", "response_definition": "bool success\nstring message"}
                client = ROS2ServiceClient(
                    f"/{asked['call']}", "std_srvs/srv/Trigger", **texts, type_hash=TRIGGER, timeout=20.0, **router
                )
                answer = client.call()
                tell(success=bool(answer.success), message=answer.message)
                client.close()
        if wanted is not None:
            publisher.publish(linear=vector(x=wanted[0], y=0.0, z=0.0), angular=vector(x=0.0, y=0.0, z=wanted[1]))
    subscriber.close()


if __name__ == "__main__":
    main(sys.argv[1])
