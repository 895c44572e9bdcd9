"""The common part of the robot's HTTP servers: listening sockets, bounds of connections, and names of the machine."""
