"""The database: what the robot is, as rows; the only place that opens it."""
