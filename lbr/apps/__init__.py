"""Apps: what uses the robot without owning a device or the motion."""
