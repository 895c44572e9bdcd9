"""Sensors of distance as rows: where each sits and looks; the ring of robots on wheels becomes five of them."""

from alembic import op

revision = "0009"
down_revision = "0008"

RING = """
INSERT INTO range_sensor (robot, name, kind, x_m, y_m, z_m, yaw_rad, pitch_rad, fov_rad, min_m, max_m, rays, stop_m)
SELECT base.robot, ring.name, 'ultrasonic', base.length_m / 2 * ring.ahead, base.width_m / 2 * ring.aside, 0.3,
       ring.yaw_rad, ring.pitch_rad, 0.4, 0.17, 8, 1, NULL
FROM (
    SELECT robot.name AS robot,
           coalesce(max(json_extract(c.settings, '$.body_length_m')), 0.43) AS length_m,
           coalesce(max(json_extract(c.settings, '$.body_width_m')), 0.30) AS width_m
    FROM robot LEFT JOIN capability AS c ON c.robot = robot.name AND c.kind IN ('drive', 'ultrasonic_ring')
    GROUP BY robot.name
    HAVING count(c.name) > 0 OR robot.name = 'lbr'
) AS base, (
    SELECT 'forward' AS name, 1 AS ahead, 0 AS aside, 0.0 AS yaw_rad, 0.0 AS pitch_rad
    UNION ALL SELECT 'back', -1, 0, 3.141592653589793, 0.0
    UNION ALL SELECT 'left', 0, 1, 1.5707963267948966, 0.0
    UNION ALL SELECT 'right', 0, -1, -1.5707963267948966, 0.0
    UNION ALL SELECT 'bottom', 0, 0, 0.0, 1.5707963267948966
) AS ring
"""

STATEMENTS = (
    """
CREATE TABLE range_sensor (
    robot     TEXT    NOT NULL REFERENCES robot (name) ON UPDATE CASCADE ON DELETE CASCADE,
    name      TEXT    NOT NULL
        CHECK (name GLOB '[a-z]*' AND name NOT GLOB '*[^a-z0-9_]*' AND length(name) <= 40),
    kind      TEXT    NOT NULL
        CHECK (kind IN ('ultrasonic', 'infrared', 'time_of_flight', 'lidar')),
    x_m       REAL    NOT NULL DEFAULT 0
        CHECK (x_m BETWEEN -5 AND 5),
    y_m       REAL    NOT NULL DEFAULT 0
        CHECK (y_m BETWEEN -5 AND 5),
    z_m       REAL    NOT NULL DEFAULT 0.2
        CHECK (z_m BETWEEN 0 AND 5),
    yaw_rad   REAL    NOT NULL DEFAULT 0
        CHECK (yaw_rad BETWEEN -7 AND 7),
    pitch_rad REAL    NOT NULL DEFAULT 0
        CHECK (pitch_rad BETWEEN -2 AND 2),
    fov_rad   REAL    NOT NULL DEFAULT 0.4
        CHECK (fov_rad > 0 AND fov_rad <= 6.2832),
    min_m     REAL    NOT NULL DEFAULT 0.02
        CHECK (min_m BETWEEN 0 AND 100),
    max_m     REAL    NOT NULL DEFAULT 4
        CHECK (max_m > 0 AND max_m <= 100),
    rays      INTEGER NOT NULL DEFAULT 1
        CHECK (rays BETWEEN 1 AND 4096),
    stop_m    REAL    DEFAULT 0.25
        CHECK (stop_m > 0 AND stop_m <= 10),
    PRIMARY KEY (robot, name),
    CHECK (min_m < max_m)
) STRICT
    """,
    RING,
    """
CREATE TRIGGER range_sensor_insert AFTER INSERT ON range_sensor
BEGIN
    INSERT INTO revision (table_name, row_key, operation, old_row, new_row)
    VALUES ('range_sensor', json_array(NEW.robot, NEW.name), 'insert',
            NULL,
            json_object('robot', NEW.robot, 'name', NEW.name, 'kind', NEW.kind, 'x_m', NEW.x_m, 'y_m', NEW.y_m,
            'z_m', NEW.z_m, 'yaw_rad', NEW.yaw_rad, 'pitch_rad', NEW.pitch_rad, 'fov_rad', NEW.fov_rad,
            'min_m', NEW.min_m, 'max_m', NEW.max_m, 'rays', NEW.rays, 'stop_m', NEW.stop_m));
END;
    """,
    """
CREATE TRIGGER range_sensor_update AFTER UPDATE ON range_sensor
WHEN (OLD.robot, OLD.name, OLD.kind, OLD.x_m, OLD.y_m, OLD.z_m, OLD.yaw_rad, OLD.pitch_rad, OLD.fov_rad,
     OLD.min_m, OLD.max_m, OLD.rays, OLD.stop_m)
     IS NOT (NEW.robot, NEW.name, NEW.kind, NEW.x_m, NEW.y_m, NEW.z_m, NEW.yaw_rad, NEW.pitch_rad, NEW.fov_rad,
     NEW.min_m, NEW.max_m, NEW.rays, NEW.stop_m)
BEGIN
    INSERT INTO revision (table_name, row_key, operation, old_row, new_row)
    VALUES ('range_sensor', json_array(NEW.robot, NEW.name), 'update',
            json_object('robot', OLD.robot, 'name', OLD.name, 'kind', OLD.kind, 'x_m', OLD.x_m, 'y_m', OLD.y_m,
            'z_m', OLD.z_m, 'yaw_rad', OLD.yaw_rad, 'pitch_rad', OLD.pitch_rad, 'fov_rad', OLD.fov_rad,
            'min_m', OLD.min_m, 'max_m', OLD.max_m, 'rays', OLD.rays, 'stop_m', OLD.stop_m),
            json_object('robot', NEW.robot, 'name', NEW.name, 'kind', NEW.kind, 'x_m', NEW.x_m, 'y_m', NEW.y_m,
            'z_m', NEW.z_m, 'yaw_rad', NEW.yaw_rad, 'pitch_rad', NEW.pitch_rad, 'fov_rad', NEW.fov_rad,
            'min_m', NEW.min_m, 'max_m', NEW.max_m, 'rays', NEW.rays, 'stop_m', NEW.stop_m));
END;
    """,
    """
CREATE TRIGGER range_sensor_delete AFTER DELETE ON range_sensor
BEGIN
    INSERT INTO revision (table_name, row_key, operation, old_row, new_row)
    VALUES ('range_sensor', json_array(OLD.robot, OLD.name), 'delete',
            json_object('robot', OLD.robot, 'name', OLD.name, 'kind', OLD.kind, 'x_m', OLD.x_m, 'y_m', OLD.y_m,
            'z_m', OLD.z_m, 'yaw_rad', OLD.yaw_rad, 'pitch_rad', OLD.pitch_rad, 'fov_rad', OLD.fov_rad,
            'min_m', OLD.min_m, 'max_m', OLD.max_m, 'rays', OLD.rays, 'stop_m', OLD.stop_m),
            NULL);
END;
    """,
)


def upgrade() -> None:
    """Add the table. Every robot that has a drive or a ring of ultrasonic sensors gets the five rows that it was before."""
    for statement in STATEMENTS:
        op.execute(statement)


def downgrade() -> None:
    """Change nothing: an older database is kept as a backup whenever one is upgraded."""
