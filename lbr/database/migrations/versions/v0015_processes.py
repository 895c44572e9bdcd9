"""Capabilities may share a process."""

from alembic import op

revision = "0015"
down_revision = "0014"

STATEMENTS = (
    """
ALTER TABLE capability ADD COLUMN process TEXT NOT NULL DEFAULT ''
    CHECK (process = '' OR (process GLOB '[a-z]*' AND process NOT GLOB '*[^a-z0-9_]*' AND length(process) <= 40))
    """,
    "DROP TRIGGER capability_insert",
    "DROP TRIGGER capability_update",
    "DROP TRIGGER capability_delete",
    """
CREATE TRIGGER capability_insert AFTER INSERT ON capability
BEGIN
    INSERT INTO revision (table_name, row_key, operation, old_row, new_row)
    VALUES ('capability', json_array(NEW.robot, NEW.name), 'insert',
            NULL,
            json_object('robot', NEW.robot, 'name', NEW.name, 'kind', NEW.kind, 'enabled', NEW.enabled, 'settings',
            NEW.settings, 'restart', NEW.restart, 'needs', NEW.needs, 'help', NEW.help, 'process', NEW.process));
END;
    """,
    """
CREATE TRIGGER capability_update AFTER UPDATE ON capability
WHEN (OLD.robot, OLD.name, OLD.kind, OLD.enabled, OLD.settings, OLD.restart, OLD.needs, OLD.help, OLD.process)
     IS NOT (NEW.robot, NEW.name, NEW.kind, NEW.enabled, NEW.settings, NEW.restart, NEW.needs, NEW.help, NEW.process)
BEGIN
    INSERT INTO revision (table_name, row_key, operation, old_row, new_row)
    VALUES ('capability', json_array(NEW.robot, NEW.name), 'update',
            json_object('robot', OLD.robot, 'name', OLD.name, 'kind', OLD.kind, 'enabled', OLD.enabled, 'settings',
            OLD.settings, 'restart', OLD.restart, 'needs', OLD.needs, 'help', OLD.help, 'process', OLD.process),
            json_object('robot', NEW.robot, 'name', NEW.name, 'kind', NEW.kind, 'enabled', NEW.enabled, 'settings',
            NEW.settings, 'restart', NEW.restart, 'needs', NEW.needs, 'help', NEW.help, 'process', NEW.process));
END;
    """,
    """
CREATE TRIGGER capability_delete AFTER DELETE ON capability
BEGIN
    INSERT INTO revision (table_name, row_key, operation, old_row, new_row)
    VALUES ('capability', json_array(OLD.robot, OLD.name), 'delete',
            json_object('robot', OLD.robot, 'name', OLD.name, 'kind', OLD.kind, 'enabled', OLD.enabled, 'settings',
            OLD.settings, 'restart', OLD.restart, 'needs', OLD.needs, 'help', OLD.help, 'process', OLD.process),
            NULL);
END;
    """,
)


def upgrade() -> None:
    """Add the column: each has a process of its own, as before; and have the revisions keep it."""
    for statement in STATEMENTS:
        op.execute(statement)


def downgrade() -> None:
    """Change nothing: an older database is kept as a backup whenever one is upgraded."""
