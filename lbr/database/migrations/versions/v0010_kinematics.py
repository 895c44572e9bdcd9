"""Wheels of any number and kind as rows, and the base that they make."""

from alembic import op

revision = "0010"
down_revision = "0009"

STATEMENTS = (
    """
CREATE TABLE kinematics (
    robot        TEXT NOT NULL REFERENCES robot (name) ON UPDATE CASCADE ON DELETE CASCADE,
    name         TEXT NOT NULL
        CHECK (name GLOB '[a-z]*' AND name NOT GLOB '*[^a-z0-9_]*' AND length(name) <= 40),
    kind         TEXT NOT NULL
        CHECK (kind IN ('differential', 'skid', 'mecanum', 'omni')),
    track_factor REAL NOT NULL DEFAULT 1
        CHECK (track_factor BETWEEN 0.5 AND 5),
    PRIMARY KEY (robot, name)
) STRICT
    """,
    """
CREATE TABLE wheel (
    robot      TEXT NOT NULL REFERENCES robot (name) ON UPDATE CASCADE ON DELETE CASCADE,
    name       TEXT NOT NULL
        CHECK (name GLOB '[a-z]*' AND name NOT GLOB '*[^a-z0-9_]*' AND length(name) <= 40),
    motor      TEXT NOT NULL
        CHECK (motor GLOB '[a-z]*' AND motor NOT GLOB '*[^a-z0-9_]*' AND length(motor) <= 40),
    x_m        REAL NOT NULL DEFAULT 0
        CHECK (x_m BETWEEN -5 AND 5),
    y_m        REAL NOT NULL DEFAULT 0
        CHECK (y_m BETWEEN -5 AND 5),
    yaw_rad    REAL NOT NULL DEFAULT 0
        CHECK (yaw_rad BETWEEN -7 AND 7),
    roller_rad REAL NOT NULL DEFAULT 0
        CHECK (roller_rad BETWEEN -1.4 AND 1.4),
    diameter_m REAL NOT NULL
        CHECK (diameter_m > 0 AND diameter_m <= 2),
    PRIMARY KEY (robot, name)
) STRICT
    """,
    """
CREATE TRIGGER kinematics_insert AFTER INSERT ON kinematics
BEGIN
    INSERT INTO revision (table_name, row_key, operation, old_row, new_row)
    VALUES ('kinematics', json_array(NEW.robot, NEW.name), 'insert',
            NULL,
            json_object('robot', NEW.robot, 'name', NEW.name, 'kind', NEW.kind, 'track_factor', NEW.track_factor));
END;
    """,
    """
CREATE TRIGGER kinematics_update AFTER UPDATE ON kinematics
WHEN (OLD.robot, OLD.name, OLD.kind, OLD.track_factor)
     IS NOT (NEW.robot, NEW.name, NEW.kind, NEW.track_factor)
BEGIN
    INSERT INTO revision (table_name, row_key, operation, old_row, new_row)
    VALUES ('kinematics', json_array(NEW.robot, NEW.name), 'update',
            json_object('robot', OLD.robot, 'name', OLD.name, 'kind', OLD.kind, 'track_factor', OLD.track_factor),
            json_object('robot', NEW.robot, 'name', NEW.name, 'kind', NEW.kind, 'track_factor', NEW.track_factor));
END;
    """,
    """
CREATE TRIGGER kinematics_delete AFTER DELETE ON kinematics
BEGIN
    INSERT INTO revision (table_name, row_key, operation, old_row, new_row)
    VALUES ('kinematics', json_array(OLD.robot, OLD.name), 'delete',
            json_object('robot', OLD.robot, 'name', OLD.name, 'kind', OLD.kind, 'track_factor', OLD.track_factor),
            NULL);
END;
    """,
    """
CREATE TRIGGER wheel_insert AFTER INSERT ON wheel
BEGIN
    INSERT INTO revision (table_name, row_key, operation, old_row, new_row)
    VALUES ('wheel', json_array(NEW.robot, NEW.name), 'insert',
            NULL,
            json_object('robot', NEW.robot, 'name', NEW.name, 'motor', NEW.motor, 'x_m', NEW.x_m, 'y_m', NEW.y_m, 'yaw_rad',
            NEW.yaw_rad, 'roller_rad', NEW.roller_rad, 'diameter_m', NEW.diameter_m));
END;
    """,
    """
CREATE TRIGGER wheel_update AFTER UPDATE ON wheel
WHEN (OLD.robot, OLD.name, OLD.motor, OLD.x_m, OLD.y_m, OLD.yaw_rad, OLD.roller_rad, OLD.diameter_m)
     IS NOT (NEW.robot, NEW.name, NEW.motor, NEW.x_m, NEW.y_m, NEW.yaw_rad, NEW.roller_rad, NEW.diameter_m)
BEGIN
    INSERT INTO revision (table_name, row_key, operation, old_row, new_row)
    VALUES ('wheel', json_array(NEW.robot, NEW.name), 'update',
            json_object('robot', OLD.robot, 'name', OLD.name, 'motor', OLD.motor, 'x_m', OLD.x_m, 'y_m', OLD.y_m, 'yaw_rad',
            OLD.yaw_rad, 'roller_rad', OLD.roller_rad, 'diameter_m', OLD.diameter_m),
            json_object('robot', NEW.robot, 'name', NEW.name, 'motor', NEW.motor, 'x_m', NEW.x_m, 'y_m', NEW.y_m, 'yaw_rad',
            NEW.yaw_rad, 'roller_rad', NEW.roller_rad, 'diameter_m', NEW.diameter_m));
END;
    """,
    """
CREATE TRIGGER wheel_delete AFTER DELETE ON wheel
BEGIN
    INSERT INTO revision (table_name, row_key, operation, old_row, new_row)
    VALUES ('wheel', json_array(OLD.robot, OLD.name), 'delete',
            json_object('robot', OLD.robot, 'name', OLD.name, 'motor', OLD.motor, 'x_m', OLD.x_m, 'y_m', OLD.y_m, 'yaw_rad',
            OLD.yaw_rad, 'roller_rad', OLD.roller_rad, 'diameter_m', OLD.diameter_m),
            NULL);
END;
    """,
)


def upgrade() -> None:
    """Add the tables. A robot without rows in them has two driven wheels, as every one had before."""
    for statement in STATEMENTS:
        op.execute(statement)


def downgrade() -> None:
    """Change nothing: an older database is kept as a backup whenever one is upgraded."""
