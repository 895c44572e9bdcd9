"""`autodock`: runs the robot's table `dock`, and prints the end. The table is the strategy; `beacon` moves."""
