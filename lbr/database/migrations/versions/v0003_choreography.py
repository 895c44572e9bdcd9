"""Dances as rows."""

from alembic import op

revision = "0003"
down_revision = "0002"

STATEMENTS = (
    """
CREATE TABLE choreography (
    robot     TEXT    NOT NULL REFERENCES robot (name) ON UPDATE CASCADE ON DELETE CASCADE,  -- whose it is
    dance     TEXT    NOT NULL  -- by which settings and commands know it
        CHECK (dance GLOB '[a-z]*' AND dance NOT GLOB '*[^a-z0-9_]*' AND length(dance) <= 40),
    step      INTEGER NOT NULL  -- the order, from 1; after the last comes the first
        CHECK (step BETWEEN 1 AND 10000),
    power     REAL    NOT NULL  -- 0 to 1 of full
        CHECK (power BETWEEN 0 AND 1),
    angle_deg REAL    NOT NULL  -- degrees clockwise: 0 ahead, 90 right, 180 back, 270 left
        CHECK (angle_deg BETWEEN -360 AND 360),
    beats     INTEGER NOT NULL DEFAULT 1  -- for how many beats
        CHECK (beats BETWEEN 1 AND 64),
    PRIMARY KEY (robot, dance, step)
) STRICT;
    """,
    """
CREATE TRIGGER choreography_insert AFTER INSERT ON choreography
BEGIN
    INSERT INTO revision (table_name, row_key, operation, old_row, new_row)
    VALUES ('choreography', json_array(NEW.robot, NEW.dance, NEW.step), 'insert',
            NULL,
            json_object('robot', NEW.robot, 'dance', NEW.dance, 'step', NEW.step, 'power', NEW.power,
            'angle_deg', NEW.angle_deg, 'beats', NEW.beats));
END;
    """,
    """
CREATE TRIGGER choreography_update AFTER UPDATE ON choreography
WHEN (OLD.robot, OLD.dance, OLD.step, OLD.power, OLD.angle_deg, OLD.beats)
     IS NOT (NEW.robot, NEW.dance, NEW.step, NEW.power, NEW.angle_deg, NEW.beats)
BEGIN
    INSERT INTO revision (table_name, row_key, operation, old_row, new_row)
    VALUES ('choreography', json_array(NEW.robot, NEW.dance, NEW.step), 'update',
            json_object('robot', OLD.robot, 'dance', OLD.dance, 'step', OLD.step, 'power', OLD.power,
            'angle_deg', OLD.angle_deg, 'beats', OLD.beats),
            json_object('robot', NEW.robot, 'dance', NEW.dance, 'step', NEW.step, 'power', NEW.power,
            'angle_deg', NEW.angle_deg, 'beats', NEW.beats));
END;
    """,
    """
CREATE TRIGGER choreography_delete AFTER DELETE ON choreography
BEGIN
    INSERT INTO revision (table_name, row_key, operation, old_row, new_row)
    VALUES ('choreography', json_array(OLD.robot, OLD.dance, OLD.step), 'delete',
            json_object('robot', OLD.robot, 'dance', OLD.dance, 'step', OLD.step, 'power', OLD.power,
            'angle_deg', OLD.angle_deg, 'beats', OLD.beats),
            NULL);
END;
    """,
)


def upgrade() -> None:
    """Add the table, and the triggers that keep its revisions."""
    for statement in STATEMENTS:
        op.execute(statement)


def downgrade() -> None:
    """Change nothing: an older database is kept as a backup whenever one is upgraded."""
