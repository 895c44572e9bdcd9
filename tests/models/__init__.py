"""Programs beside the robot: models of what it must do, and its parts in lockstep, without a process of its own."""
