"""Steps of the schema, one Alembic revision each, applied by lbr.database.migrate when it opens an older file.

`python docs/generate.py --step NAME` writes a step from robot.db.sql and the declared tables. It makes new tables, and
rebuilds each changed one with its former columns. Check the other columns by hand. A step is never edited later; its
number is that of the schema.
"""
