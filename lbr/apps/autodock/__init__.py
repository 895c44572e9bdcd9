"""`autodock`: has the robot run its table `dock`, and prints the end. The table is the strategy, `beacon`
moves."""
