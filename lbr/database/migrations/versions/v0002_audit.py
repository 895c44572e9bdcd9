"""When tokens end, the audit trail, and the row sets that ran."""

from alembic import op

revision = "0002"
down_revision = "0001"

TABLES = (
    """
CREATE TABLE audit (
    id       INTEGER NOT NULL PRIMARY KEY AUTOINCREMENT,  -- counts up without a gap
    wall_ns  INTEGER NOT NULL  -- nanoseconds since 1970 by the wall clock
        CHECK (wall_ns >= 0),
    kind     TEXT    NOT NULL,  -- run, shutdown, holder, stopped, estop, login, rows_changed, python ...
    subject  TEXT    NOT NULL,  -- the capability, or whom it is about
    source   TEXT    NOT NULL,  -- who said so, as robot/capability
    text     TEXT    NOT NULL,  -- one sentence
    previous TEXT    NOT NULL,  -- the hash of the row before; empty for the very first
    hash     TEXT    NOT NULL   -- BLAKE2b over all of this row but itself
) STRICT;
    """,
    """
CREATE TABLE adopted (
    revision INTEGER NOT NULL PRIMARY KEY,  -- the last change of rows that was in it; 0: none
    hash     TEXT    NOT NULL,              -- BLAKE2b over the rows that make robots
    wall_ns  INTEGER NOT NULL               -- when it was adopted first, nanoseconds since 1970
        CHECK (wall_ns >= 0)
) STRICT;
    """,
)
TRIGGERS = (
    """
CREATE TRIGGER audit_insert BEFORE INSERT ON audit
WHEN NEW.previous IS NOT (SELECT hash FROM audit ORDER BY id DESC LIMIT 1) AND EXISTS (SELECT 1 FROM audit)
BEGIN
    SELECT RAISE(ABORT, 'the audit trail goes on where it ended: previous must be the hash of its last row');
END;
    """,
    """
CREATE TRIGGER audit_update BEFORE UPDATE ON audit
BEGIN
    SELECT RAISE(ABORT, 'the audit trail is never changed');
END;
    """,
    """
CREATE TRIGGER audit_delete BEFORE DELETE ON audit
WHEN OLD.id > (SELECT max(id) FROM audit) - 20000
BEGIN
    SELECT RAISE(ABORT, 'the audit trail gives up only what is older than its newest 20000 rows');
END;
    """,
)


def upgrade() -> None:
    """Add the column and the tables."""
    op.execute("ALTER TABLE user_token ADD COLUMN expires_at TEXT")
    for statement in (*TABLES, *TRIGGERS):
        op.execute(statement)


def downgrade() -> None:
    """Change nothing: an older database is kept as a backup whenever one is upgraded."""
