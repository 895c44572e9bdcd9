"""The part of the bridge to ROS in `lbr doctor`."""
