"""Changes of the schema, one Alembic revision each, applied by lbr.database.migrate when it opens an older file.

A change needs three things: a revision in `versions` (`vNNNN_what.py`, following the newest), the same change in
robot.db.sql with its stamp, and `HEAD` in lbr/database/migrate.py. Tests hold the three together.

Write `op.add_column`, or SQLite's own ALTER TABLE by `op.execute`. Alembic's batch operations must not be used: they
build the table again without its CHECKs and STRICT. What ALTER TABLE cannot do takes a new table, a copy, a drop and
a rename, and then the table's triggers again: `lbr.database.triggers` writes them from the columns.
"""
