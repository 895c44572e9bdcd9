"""The same on other machines: an agent there, and what the robot's own machine knows of it."""
