"""Where the robot listens, when tokens end, the audit trail, and the row sets that ran."""

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
COLUMNS = (
    (
        "ALTER TABLE robot ADD COLUMN listen TEXT NOT NULL DEFAULT '[]'"
        " CHECK (json_valid(listen) AND json_type(listen) = 'array')"
    ),
    "ALTER TABLE user_token ADD COLUMN expires_at TEXT",
)
TRIGGERS = (
    """
CREATE TRIGGER robot_insert AFTER INSERT ON robot
BEGIN
    INSERT INTO revision (table_name, row_key, operation, old_row, new_row)
    VALUES ('robot', json_array(NEW.name), 'insert',
            NULL,
            json_object('name', NEW.name, 'model', NEW.model, 'description', NEW.description, 'owner', NEW.owner,
            'listen', NEW.listen));
END;
    """,
    """
CREATE TRIGGER robot_update AFTER UPDATE ON robot
WHEN (OLD.name, OLD.model, OLD.description, OLD.owner, OLD.listen)
     IS NOT (NEW.name, NEW.model, NEW.description, NEW.owner, NEW.listen)
BEGIN
    INSERT INTO revision (table_name, row_key, operation, old_row, new_row)
    VALUES ('robot', json_array(NEW.name), 'update',
            json_object('name', OLD.name, 'model', OLD.model, 'description', OLD.description, 'owner', OLD.owner,
            'listen', OLD.listen),
            json_object('name', NEW.name, 'model', NEW.model, 'description', NEW.description, 'owner', NEW.owner,
            'listen', NEW.listen));
END;
    """,
    """
CREATE TRIGGER robot_delete AFTER DELETE ON robot
BEGIN
    INSERT INTO revision (table_name, row_key, operation, old_row, new_row)
    VALUES ('robot', json_array(OLD.name), 'delete',
            json_object('name', OLD.name, 'model', OLD.model, 'description', OLD.description, 'owner', OLD.owner,
            'listen', OLD.listen),
            NULL);
END;
    """,
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
    """Add the columns and tables, and let the revisions of a robot's row tell where it listens."""
    for name in ("robot_insert", "robot_update", "robot_delete"):
        op.execute(f"DROP TRIGGER {name}")
    for statement in (*COLUMNS, *TABLES, *TRIGGERS):
        op.execute(statement)


def downgrade() -> None:
    """Change nothing: an older database is kept as a backup whenever one is upgraded."""
