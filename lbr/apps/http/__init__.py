"""The common part of the robot's HTTP servers: where they listen, the bounds of a connection, and the names by which
they are asked."""
