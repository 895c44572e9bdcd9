"""The robot in ROS 2 by the wire of rmw_zenoh: its sensors are published there, and ROS drives it under a lease.

Pure are `codec` (messages as bytes), `wire` (keys and tokens), `graph` (the nodes in ROS) and `driving` (the twist to
follow). `topics`, `shown` and `urdf`, the robot's messages and its body, are pure too. `link` is the connection, in a
thread of its own. `words` are the services, and `capability` is the process.
"""

from lbr.component import Component

COMPONENT = Component(
    kinds={"ros2": "lbr.apps.ros2.kind:KIND"},
    checks={"ros2": "lbr.apps.ros2.commands.checks:router"},
    messages=("lbr.apps.ros2.messages",),
)
