"""What the robot's emulated cameras see, drawn in a process of its own so that the world's devices answer in time."""
