"""`autodock`: has the robot run its table `dock`, and tells how that ended. The table is the strategy, `beacon`
moves."""
