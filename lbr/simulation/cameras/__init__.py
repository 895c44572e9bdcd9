"""The view of the robot's emulated cameras, drawn in its own process so that the world's devices answer in time."""
