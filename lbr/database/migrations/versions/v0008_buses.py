"""Joints say on which bus their servo is, so that one robot has several arms."""

from alembic import op

revision = "0008"
down_revision = "0007"

STATEMENTS = (
    "DROP TRIGGER joint_insert",
    "DROP TRIGGER joint_update",
    "DROP TRIGGER joint_delete",
    """
ALTER TABLE joint ADD COLUMN bus TEXT NOT NULL DEFAULT ''
    CHECK (bus = '' OR (bus GLOB '[a-z]*' AND bus NOT GLOB '*[^a-z0-9_]*' AND length(bus) <= 40))
    """,
    """
CREATE TRIGGER joint_insert AFTER INSERT ON joint
BEGIN
    INSERT INTO revision (table_name, row_key, operation, old_row, new_row)
    VALUES ('joint', json_array(NEW.robot, NEW.name), 'insert',
            NULL,
            json_object('robot', NEW.robot, 'name', NEW.name, 'device_id', NEW.device_id, 'side', NEW.side,
            'sign', NEW.sign, 'zero_rad', NEW.zero_rad, 'lower_rad', NEW.lower_rad, 'upper_rad', NEW.upper_rad,
            'speed_rps', NEW.speed_rps, 'bus', NEW.bus));
END;
    """,
    """
CREATE TRIGGER joint_update AFTER UPDATE ON joint
WHEN (OLD.robot, OLD.name, OLD.device_id, OLD.side, OLD.sign, OLD.zero_rad, OLD.lower_rad, OLD.upper_rad, OLD.speed_rps, OLD.bus)
     IS NOT (NEW.robot, NEW.name, NEW.device_id, NEW.side, NEW.sign, NEW.zero_rad, NEW.lower_rad, NEW.upper_rad, NEW.speed_rps, NEW.bus)
BEGIN
    INSERT INTO revision (table_name, row_key, operation, old_row, new_row)
    VALUES ('joint', json_array(NEW.robot, NEW.name), 'update',
            json_object('robot', OLD.robot, 'name', OLD.name, 'device_id', OLD.device_id, 'side', OLD.side,
            'sign', OLD.sign, 'zero_rad', OLD.zero_rad, 'lower_rad', OLD.lower_rad, 'upper_rad', OLD.upper_rad,
            'speed_rps', OLD.speed_rps, 'bus', OLD.bus),
            json_object('robot', NEW.robot, 'name', NEW.name, 'device_id', NEW.device_id, 'side', NEW.side,
            'sign', NEW.sign, 'zero_rad', NEW.zero_rad, 'lower_rad', NEW.lower_rad, 'upper_rad', NEW.upper_rad,
            'speed_rps', NEW.speed_rps, 'bus', NEW.bus));
END;
    """,
    """
CREATE TRIGGER joint_delete AFTER DELETE ON joint
BEGIN
    INSERT INTO revision (table_name, row_key, operation, old_row, new_row)
    VALUES ('joint', json_array(OLD.robot, OLD.name), 'delete',
            json_object('robot', OLD.robot, 'name', OLD.name, 'device_id', OLD.device_id, 'side', OLD.side,
            'sign', OLD.sign, 'zero_rad', OLD.zero_rad, 'lower_rad', OLD.lower_rad, 'upper_rad', OLD.upper_rad,
            'speed_rps', OLD.speed_rps, 'bus', OLD.bus),
            NULL);
END;
    """,
)


def upgrade() -> None:
    """Add the column: a joint that names no bus is on the one that its robot has."""
    for statement in STATEMENTS:
        op.execute(statement)


def downgrade() -> None:
    """Change nothing: an older database is kept as a backup whenever one is upgraded."""
