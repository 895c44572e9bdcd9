"""A robot's processes on other machines: the agent there, and its counterpart on the robot's own machine."""
