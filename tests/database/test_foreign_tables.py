"""The rows of another program's database, read out of its file or its dump."""

from lbr.database import foreign_tables


def test_what_sqlite_keeps_for_itself_is_no_table_of_the_other_program():
    dump = "CREATE TABLE step (id INTEGER PRIMARY KEY AUTOINCREMENT, x); INSERT INTO step (x) VALUES (5);"
    assert foreign_tables.of_sql(dump) == {"step": [{"id": 1, "x": 5}]}
