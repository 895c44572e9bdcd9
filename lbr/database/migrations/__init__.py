"""Changes of the schema, one Alembic revision each, applied by lbr.database.migrate when it opens an older file.

A change needs three things: a revision in `versions` (`vNNNN_what.py`, following the newest), the same change in
robot.db.sql with its stamp, and `HEAD` in lbr/database/migrate.py. Tests hold the three together. Tables that keep
revisions have triggers: a migration that rebuilds one must create its triggers again.
"""
