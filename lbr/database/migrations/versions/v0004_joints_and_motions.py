"""Joints and motions make a robot: their changes are revisions, and a motion may lead into another."""

from alembic import op

revision = "0004"
down_revision = "0003"

STATEMENTS = (
    """
ALTER TABLE motion ADD COLUMN lead_in TEXT NOT NULL DEFAULT ''
    CHECK (lead_in = '' OR (lead_in GLOB '[a-z]*' AND lead_in NOT GLOB '*[^a-z0-9_]*'));
    """,
    """
ALTER TABLE motion ADD COLUMN lead_out TEXT NOT NULL DEFAULT ''
    CHECK (lead_out = '' OR (lead_out GLOB '[a-z]*' AND lead_out NOT GLOB '*[^a-z0-9_]*'));
    """,
    """
CREATE TRIGGER joint_insert AFTER INSERT ON joint
BEGIN
    INSERT INTO revision (table_name, row_key, operation, old_row, new_row)
    VALUES ('joint', json_array(NEW.robot, NEW.name), 'insert',
            NULL,
            json_object('robot', NEW.robot, 'name', NEW.name, 'device_id', NEW.device_id, 'side', NEW.side,
            'sign', NEW.sign, 'zero_rad', NEW.zero_rad, 'lower_rad', NEW.lower_rad, 'upper_rad', NEW.upper_rad,
            'speed_rps', NEW.speed_rps));
END;
    """,
    """
CREATE TRIGGER joint_update AFTER UPDATE ON joint
WHEN (OLD.robot, OLD.name, OLD.device_id, OLD.side, OLD.sign, OLD.zero_rad, OLD.lower_rad, OLD.upper_rad, OLD.speed_rps)
     IS NOT (NEW.robot, NEW.name, NEW.device_id, NEW.side, NEW.sign, NEW.zero_rad, NEW.lower_rad, NEW.upper_rad, NEW.speed_rps)
BEGIN
    INSERT INTO revision (table_name, row_key, operation, old_row, new_row)
    VALUES ('joint', json_array(NEW.robot, NEW.name), 'update',
            json_object('robot', OLD.robot, 'name', OLD.name, 'device_id', OLD.device_id, 'side', OLD.side,
            'sign', OLD.sign, 'zero_rad', OLD.zero_rad, 'lower_rad', OLD.lower_rad, 'upper_rad', OLD.upper_rad,
            'speed_rps', OLD.speed_rps),
            json_object('robot', NEW.robot, 'name', NEW.name, 'device_id', NEW.device_id, 'side', NEW.side,
            'sign', NEW.sign, 'zero_rad', NEW.zero_rad, 'lower_rad', NEW.lower_rad, 'upper_rad', NEW.upper_rad,
            'speed_rps', NEW.speed_rps));
END;
    """,
    """
CREATE TRIGGER joint_delete AFTER DELETE ON joint
BEGIN
    INSERT INTO revision (table_name, row_key, operation, old_row, new_row)
    VALUES ('joint', json_array(OLD.robot, OLD.name), 'delete',
            json_object('robot', OLD.robot, 'name', OLD.name, 'device_id', OLD.device_id, 'side', OLD.side,
            'sign', OLD.sign, 'zero_rad', OLD.zero_rad, 'lower_rad', OLD.lower_rad, 'upper_rad', OLD.upper_rad,
            'speed_rps', OLD.speed_rps),
            NULL);
END;
    """,
    """
CREATE TRIGGER motion_insert AFTER INSERT ON motion
BEGIN
    INSERT INTO revision (table_name, row_key, operation, old_row, new_row)
    VALUES ('motion', json_array(NEW.robot, NEW.name), 'insert',
            NULL,
            json_object('robot', NEW.robot, 'name', NEW.name, 'help', NEW.help, 'lead_in', NEW.lead_in,
            'lead_out', NEW.lead_out));
END;
    """,
    """
CREATE TRIGGER motion_update AFTER UPDATE ON motion
WHEN (OLD.robot, OLD.name, OLD.help, OLD.lead_in, OLD.lead_out)
     IS NOT (NEW.robot, NEW.name, NEW.help, NEW.lead_in, NEW.lead_out)
BEGIN
    INSERT INTO revision (table_name, row_key, operation, old_row, new_row)
    VALUES ('motion', json_array(NEW.robot, NEW.name), 'update',
            json_object('robot', OLD.robot, 'name', OLD.name, 'help', OLD.help, 'lead_in', OLD.lead_in,
            'lead_out', OLD.lead_out),
            json_object('robot', NEW.robot, 'name', NEW.name, 'help', NEW.help, 'lead_in', NEW.lead_in,
            'lead_out', NEW.lead_out));
END;
    """,
    """
CREATE TRIGGER motion_delete AFTER DELETE ON motion
BEGIN
    INSERT INTO revision (table_name, row_key, operation, old_row, new_row)
    VALUES ('motion', json_array(OLD.robot, OLD.name), 'delete',
            json_object('robot', OLD.robot, 'name', OLD.name, 'help', OLD.help, 'lead_in', OLD.lead_in,
            'lead_out', OLD.lead_out),
            NULL);
END;
    """,
    """
CREATE TRIGGER motion_step_insert AFTER INSERT ON motion_step
BEGIN
    INSERT INTO revision (table_name, row_key, operation, old_row, new_row)
    VALUES ('motion_step', json_array(NEW.robot, NEW.motion, NEW.step), 'insert',
            NULL,
            json_object('robot', NEW.robot, 'motion', NEW.motion, 'step', NEW.step, 'duration_s', NEW.duration_s,
            'positions', NEW.positions));
END;
    """,
    """
CREATE TRIGGER motion_step_update AFTER UPDATE ON motion_step
WHEN (OLD.robot, OLD.motion, OLD.step, OLD.duration_s, OLD.positions)
     IS NOT (NEW.robot, NEW.motion, NEW.step, NEW.duration_s, NEW.positions)
BEGIN
    INSERT INTO revision (table_name, row_key, operation, old_row, new_row)
    VALUES ('motion_step', json_array(NEW.robot, NEW.motion, NEW.step), 'update',
            json_object('robot', OLD.robot, 'motion', OLD.motion, 'step', OLD.step, 'duration_s', OLD.duration_s,
            'positions', OLD.positions),
            json_object('robot', NEW.robot, 'motion', NEW.motion, 'step', NEW.step, 'duration_s', NEW.duration_s,
            'positions', NEW.positions));
END;
    """,
    """
CREATE TRIGGER motion_step_delete AFTER DELETE ON motion_step
BEGIN
    INSERT INTO revision (table_name, row_key, operation, old_row, new_row)
    VALUES ('motion_step', json_array(OLD.robot, OLD.motion, OLD.step), 'delete',
            json_object('robot', OLD.robot, 'motion', OLD.motion, 'step', OLD.step, 'duration_s', OLD.duration_s,
            'positions', OLD.positions),
            NULL);
END;
    """,
)


def upgrade() -> None:
    """Add the columns, and the triggers that keep the revisions."""
    for statement in STATEMENTS:
        op.execute(statement)


def downgrade() -> None:
    """Change nothing: an older database is kept as a backup whenever one is upgraded."""
