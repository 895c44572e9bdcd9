"""Apps: components that use the robot, without a device or the motion of their own."""
