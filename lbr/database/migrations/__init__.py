"""Steps of the schema, one Alembic revision each, applied by lbr.database.migrate when it opens an older file.

`python docs/generate.py --step NAME` writes one, from the tables of robot.db.sql and what they are declared to be. It
makes new tables, and has one that changed built again, with the columns that it had before: read what becomes of the
others. A step stays as it was written; its number is the schema's.
"""
