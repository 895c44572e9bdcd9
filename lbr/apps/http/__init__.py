"""What the robot's HTTP servers share: where they listen, what a connection may hold, and by which names they are
asked."""
