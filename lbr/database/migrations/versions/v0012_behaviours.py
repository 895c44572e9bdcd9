"""State tables that anyone can write."""

from alembic import op

revision = "0012"
down_revision = "0011"

STATEMENTS = (
    """
CREATE TABLE behaviour (
    robot TEXT NOT NULL REFERENCES robot (name) ON UPDATE CASCADE ON DELETE CASCADE,
    name  TEXT NOT NULL
        CHECK (name GLOB '[a-z]*' AND name NOT GLOB '*[^a-z0-9_]*' AND length(name) <= 40),
    help  TEXT NOT NULL DEFAULT '',
    max_s REAL NOT NULL DEFAULT 600
        CHECK (max_s BETWEEN 0 AND 86400),
    PRIMARY KEY (robot, name)
) STRICT
    """,
    """
CREATE TABLE behaviour_row (
    robot      TEXT    NOT NULL,
    behaviour  TEXT    NOT NULL,
    step       INTEGER NOT NULL
        CHECK (step BETWEEN 1 AND 10000),
    type       TEXT    NOT NULL DEFAULT ''
        CHECK (type IN ('', 'start', 'end', 'fail', 'entry', '#')),
    state      TEXT    NOT NULL DEFAULT ''
        CHECK (length(state) <= 80),
    conditions TEXT    NOT NULL DEFAULT '{}'
        CHECK (json_valid(conditions) AND json_type(conditions) = 'object'),
    outputs    TEXT    NOT NULL DEFAULT '{}'
        CHECK (json_valid(outputs) AND json_type(outputs) = 'object'),
    next_state TEXT    NOT NULL DEFAULT ''
        CHECK (length(next_state) <= 80),
    deadline_s REAL
        CHECK (deadline_s > 0 AND deadline_s <= 86400),
    PRIMARY KEY (robot, behaviour, step),
    FOREIGN KEY (robot, behaviour) REFERENCES behaviour (robot, name) ON UPDATE CASCADE ON DELETE CASCADE
) STRICT
    """,
    """
CREATE TRIGGER behaviour_insert AFTER INSERT ON behaviour
BEGIN
    INSERT INTO revision (table_name, row_key, operation, old_row, new_row)
    VALUES ('behaviour', json_array(NEW.robot, NEW.name), 'insert',
            NULL,
            json_object('robot', NEW.robot, 'name', NEW.name, 'help', NEW.help, 'max_s', NEW.max_s));
END;
    """,
    """
CREATE TRIGGER behaviour_update AFTER UPDATE ON behaviour
WHEN (OLD.robot, OLD.name, OLD.help, OLD.max_s)
     IS NOT (NEW.robot, NEW.name, NEW.help, NEW.max_s)
BEGIN
    INSERT INTO revision (table_name, row_key, operation, old_row, new_row)
    VALUES ('behaviour', json_array(NEW.robot, NEW.name), 'update',
            json_object('robot', OLD.robot, 'name', OLD.name, 'help', OLD.help, 'max_s', OLD.max_s),
            json_object('robot', NEW.robot, 'name', NEW.name, 'help', NEW.help, 'max_s', NEW.max_s));
END;
    """,
    """
CREATE TRIGGER behaviour_delete AFTER DELETE ON behaviour
BEGIN
    INSERT INTO revision (table_name, row_key, operation, old_row, new_row)
    VALUES ('behaviour', json_array(OLD.robot, OLD.name), 'delete',
            json_object('robot', OLD.robot, 'name', OLD.name, 'help', OLD.help, 'max_s', OLD.max_s),
            NULL);
END;
    """,
    """
CREATE TRIGGER behaviour_row_insert AFTER INSERT ON behaviour_row
BEGIN
    INSERT INTO revision (table_name, row_key, operation, old_row, new_row)
    VALUES ('behaviour_row', json_array(NEW.robot, NEW.behaviour, NEW.step), 'insert',
            NULL,
            json_object('robot', NEW.robot, 'behaviour', NEW.behaviour, 'step', NEW.step, 'type', NEW.type, 'state', NEW.state, 'conditions', NEW.conditions, 'outputs', NEW.outputs, 'next_state', NEW.next_state, 'deadline_s', NEW.deadline_s));
END;
    """,
    """
CREATE TRIGGER behaviour_row_update AFTER UPDATE ON behaviour_row
WHEN (OLD.robot, OLD.behaviour, OLD.step, OLD.type, OLD.state, OLD.conditions, OLD.outputs, OLD.next_state, OLD.deadline_s)
     IS NOT (NEW.robot, NEW.behaviour, NEW.step, NEW.type, NEW.state, NEW.conditions, NEW.outputs, NEW.next_state, NEW.deadline_s)
BEGIN
    INSERT INTO revision (table_name, row_key, operation, old_row, new_row)
    VALUES ('behaviour_row', json_array(NEW.robot, NEW.behaviour, NEW.step), 'update',
            json_object('robot', OLD.robot, 'behaviour', OLD.behaviour, 'step', OLD.step, 'type', OLD.type, 'state', OLD.state, 'conditions', OLD.conditions, 'outputs', OLD.outputs, 'next_state', OLD.next_state, 'deadline_s', OLD.deadline_s),
            json_object('robot', NEW.robot, 'behaviour', NEW.behaviour, 'step', NEW.step, 'type', NEW.type, 'state', NEW.state, 'conditions', NEW.conditions, 'outputs', NEW.outputs, 'next_state', NEW.next_state, 'deadline_s', NEW.deadline_s));
END;
    """,
    """
CREATE TRIGGER behaviour_row_delete AFTER DELETE ON behaviour_row
BEGIN
    INSERT INTO revision (table_name, row_key, operation, old_row, new_row)
    VALUES ('behaviour_row', json_array(OLD.robot, OLD.behaviour, OLD.step), 'delete',
            json_object('robot', OLD.robot, 'behaviour', OLD.behaviour, 'step', OLD.step, 'type', OLD.type, 'state', OLD.state, 'conditions', OLD.conditions, 'outputs', OLD.outputs, 'next_state', OLD.next_state, 'deadline_s', OLD.deadline_s),
            NULL);
END;
    """,
)


def upgrade() -> None:
    """Add the tables, empty."""
    for statement in STATEMENTS:
        op.execute(statement)


def downgrade() -> None:
    """Change nothing: an older database is kept as a backup whenever one is upgraded."""
