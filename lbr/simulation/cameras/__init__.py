"""The view of the robot's emulated cameras, drawn in a process of its own so that the devices answer in time."""
