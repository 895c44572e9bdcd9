"""Key frames say where the robot may come to rest."""

from alembic import op

revision = "0013"
down_revision = "0012"

STATEMENTS = (
    "ALTER TABLE motion_step ADD COLUMN stable INTEGER NOT NULL DEFAULT 0 CHECK (stable IN (0, 1))",
    "DROP TRIGGER motion_step_insert",
    "DROP TRIGGER motion_step_update",
    "DROP TRIGGER motion_step_delete",
    """
CREATE TRIGGER motion_step_insert AFTER INSERT ON motion_step
BEGIN
    INSERT INTO revision (table_name, row_key, operation, old_row, new_row)
    VALUES ('motion_step', json_array(NEW.robot, NEW.motion, NEW.step), 'insert',
            NULL,
            json_object('robot', NEW.robot, 'motion', NEW.motion, 'step', NEW.step, 'duration_s', NEW.duration_s,
            'positions', NEW.positions, 'stable', NEW.stable));
END;
    """,
    """
CREATE TRIGGER motion_step_update AFTER UPDATE ON motion_step
WHEN (OLD.robot, OLD.motion, OLD.step, OLD.duration_s, OLD.positions, OLD.stable)
     IS NOT (NEW.robot, NEW.motion, NEW.step, NEW.duration_s, NEW.positions, NEW.stable)
BEGIN
    INSERT INTO revision (table_name, row_key, operation, old_row, new_row)
    VALUES ('motion_step', json_array(NEW.robot, NEW.motion, NEW.step), 'update',
            json_object('robot', OLD.robot, 'motion', OLD.motion, 'step', OLD.step, 'duration_s', OLD.duration_s,
            'positions', OLD.positions, 'stable', OLD.stable),
            json_object('robot', NEW.robot, 'motion', NEW.motion, 'step', NEW.step, 'duration_s', NEW.duration_s,
            'positions', NEW.positions, 'stable', NEW.stable));
END;
    """,
    """
CREATE TRIGGER motion_step_delete AFTER DELETE ON motion_step
BEGIN
    INSERT INTO revision (table_name, row_key, operation, old_row, new_row)
    VALUES ('motion_step', json_array(OLD.robot, OLD.motion, OLD.step), 'delete',
            json_object('robot', OLD.robot, 'motion', OLD.motion, 'step', OLD.step, 'duration_s', OLD.duration_s,
            'positions', OLD.positions, 'stable', OLD.stable),
            NULL);
END;
    """,
)


def upgrade() -> None:
    """Add the column, and have the revisions keep it."""
    for statement in STATEMENTS:
        op.execute(statement)


def downgrade() -> None:
    """Change nothing: an older database is kept as a backup whenever one is upgraded."""
