"""What follows the name of an external command, and who may start it; where a token lets in; words of no row."""

from alembic import op

revision = "0007"
down_revision = "0006"

STATEMENTS = (
    "DROP TRIGGER external_command_insert",
    "DROP TRIGGER external_command_update",
    "DROP TRIGGER external_command_delete",
    """
ALTER TABLE external_command ADD COLUMN arguments TEXT
    CHECK (arguments IS NULL OR (json_valid(arguments) AND json_type(arguments) = 'array'))
    """,
    """
ALTER TABLE external_command ADD COLUMN role TEXT NOT NULL DEFAULT 'operate'
    CHECK (role IN ('view', 'operate', 'admin'))
    """,
    """
UPDATE external_command
SET arguments = '[["left", "right", "power"], ["left", "right", "power"], ["left", "right", "power"]]'
WHERE argv = '["python", "-m", "lbr.apps.docksignal"]'
    """,
    "UPDATE external_command SET role = 'view' WHERE argv = '[\"/bin/date\"]'",
    """
CREATE TRIGGER external_command_insert AFTER INSERT ON external_command
BEGIN
    INSERT INTO revision (table_name, row_key, operation, old_row, new_row)
    VALUES ('external_command', json_array(NEW.robot, NEW.name), 'insert',
            NULL,
            json_object('robot', NEW.robot, 'name', NEW.name, 'argv', NEW.argv, 'blocking', NEW.blocking,
            'enabled', NEW.enabled, 'help', NEW.help, 'arguments', NEW.arguments, 'role', NEW.role));
END;
    """,
    """
CREATE TRIGGER external_command_update AFTER UPDATE ON external_command
WHEN (OLD.robot, OLD.name, OLD.argv, OLD.blocking, OLD.enabled, OLD.help, OLD.arguments, OLD.role)
     IS NOT (NEW.robot, NEW.name, NEW.argv, NEW.blocking, NEW.enabled, NEW.help, NEW.arguments, NEW.role)
BEGIN
    INSERT INTO revision (table_name, row_key, operation, old_row, new_row)
    VALUES ('external_command', json_array(NEW.robot, NEW.name), 'update',
            json_object('robot', OLD.robot, 'name', OLD.name, 'argv', OLD.argv, 'blocking', OLD.blocking,
            'enabled', OLD.enabled, 'help', OLD.help, 'arguments', OLD.arguments, 'role', OLD.role),
            json_object('robot', NEW.robot, 'name', NEW.name, 'argv', NEW.argv, 'blocking', NEW.blocking,
            'enabled', NEW.enabled, 'help', NEW.help, 'arguments', NEW.arguments, 'role', NEW.role));
END;
    """,
    """
CREATE TRIGGER external_command_delete AFTER DELETE ON external_command
BEGIN
    INSERT INTO revision (table_name, row_key, operation, old_row, new_row)
    VALUES ('external_command', json_array(OLD.robot, OLD.name), 'delete',
            json_object('robot', OLD.robot, 'name', OLD.name, 'argv', OLD.argv, 'blocking', OLD.blocking,
            'enabled', OLD.enabled, 'help', OLD.help, 'arguments', OLD.arguments, 'role', OLD.role),
            NULL);
END;
    """,
    "DROP TRIGGER verb_delete",
    """
DELETE FROM verb
WHERE lower(word) IN ('s', 'stop', 'estop', 'reset', 'status', 'help', 'shutdown')
AND (pattern IN (word, '/' || word) OR lower(word) = 'estop')
    """,
    """
CREATE TRIGGER verb_delete AFTER DELETE ON verb
BEGIN
    INSERT INTO revision (table_name, row_key, operation, old_row, new_row)
    VALUES ('verb', json_array(OLD.robot, OLD.word, OLD.pattern), 'delete',
            json_object('robot', OLD.robot, 'word', OLD.word, 'pattern', OLD.pattern, 'target', OLD.target,
            'payload', OLD.payload, 'role', OLD.role, 'help', OLD.help),
            NULL);
END;
    """,
    """
ALTER TABLE user_token ADD COLUMN good_for TEXT NOT NULL DEFAULT 'both'
    CHECK (good_for IN ('bus', 'web', 'both'))
    """,
)


def upgrade() -> None:
    """Add the columns: what was typed after a name before is taken no more, and every token lets in as it did.

    Rows of words that every robot has now, whatever they meant, go: no row may change what stops it.
    """
    for statement in STATEMENTS:
        op.execute(statement)


def downgrade() -> None:
    """Change nothing: an older database is kept as a backup whenever one is upgraded."""
