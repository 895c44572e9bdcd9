"""The bridge, or the sentence about the missing extra."""

try:
    from lbr.apps.ros2.capability import Ros2
except ModuleNotFoundError as err:
    raise ImportError(
        f"the bridge to ROS 2 needs the extra 'ros2' ({err.name} is missing): pip install 'lbr[ros2]'"
    ) from err

__all__ = ["Ros2"]
