"""The database, which describes the robot in rows; no other package opens it."""
