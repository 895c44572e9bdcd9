"""Motions that a robot's own controller plays; and how faces to the outside number and name motors and motions."""

from alembic import op

revision = "0006"
down_revision = "0005"

STATEMENTS = (
    "DROP TRIGGER motion_insert",
    "DROP TRIGGER motion_update",
    "DROP TRIGGER motion_delete",
    "ALTER TABLE motion ADD COLUMN slot INTEGER CHECK (slot BETWEEN 1 AND 255)",
    """
ALTER TABLE motion ADD COLUMN slot_s REAL
    CHECK (CASE WHEN slot IS NULL THEN slot_s IS NULL ELSE coalesce(slot_s > 0 AND slot_s <= 600, 0) END)
    """,
    "ALTER TABLE motion ADD COLUMN limp INTEGER NOT NULL DEFAULT 0 CHECK (limp IN (0, 1))",
    "ALTER TABLE motion ADD COLUMN builtin INTEGER NOT NULL DEFAULT 0 CHECK (builtin IN (0, 1))",
    """
CREATE TRIGGER motion_insert AFTER INSERT ON motion
BEGIN
    INSERT INTO revision (table_name, row_key, operation, old_row, new_row)
    VALUES ('motion', json_array(NEW.robot, NEW.name), 'insert',
            NULL,
            json_object('robot', NEW.robot, 'name', NEW.name, 'help', NEW.help, 'lead_in', NEW.lead_in,
            'lead_out', NEW.lead_out, 'slot', NEW.slot, 'slot_s', NEW.slot_s, 'limp', NEW.limp,
            'builtin', NEW.builtin));
END;
    """,
    """
CREATE TRIGGER motion_update AFTER UPDATE ON motion
WHEN (OLD.robot, OLD.name, OLD.help, OLD.lead_in, OLD.lead_out, OLD.slot, OLD.slot_s, OLD.limp, OLD.builtin)
     IS NOT (NEW.robot, NEW.name, NEW.help, NEW.lead_in, NEW.lead_out, NEW.slot, NEW.slot_s, NEW.limp, NEW.builtin)
BEGIN
    INSERT INTO revision (table_name, row_key, operation, old_row, new_row)
    VALUES ('motion', json_array(NEW.robot, NEW.name), 'update',
            json_object('robot', OLD.robot, 'name', OLD.name, 'help', OLD.help, 'lead_in', OLD.lead_in,
            'lead_out', OLD.lead_out, 'slot', OLD.slot, 'slot_s', OLD.slot_s, 'limp', OLD.limp,
            'builtin', OLD.builtin),
            json_object('robot', NEW.robot, 'name', NEW.name, 'help', NEW.help, 'lead_in', NEW.lead_in,
            'lead_out', NEW.lead_out, 'slot', NEW.slot, 'slot_s', NEW.slot_s, 'limp', NEW.limp,
            'builtin', NEW.builtin));
END;
    """,
    """
CREATE TRIGGER motion_delete AFTER DELETE ON motion
BEGIN
    INSERT INTO revision (table_name, row_key, operation, old_row, new_row)
    VALUES ('motion', json_array(OLD.robot, OLD.name), 'delete',
            json_object('robot', OLD.robot, 'name', OLD.name, 'help', OLD.help, 'lead_in', OLD.lead_in,
            'lead_out', OLD.lead_out, 'slot', OLD.slot, 'slot_s', OLD.slot_s, 'limp', OLD.limp,
            'builtin', OLD.builtin),
            NULL);
END;
    """,
    """
CREATE TABLE motor (
    robot       TEXT    NOT NULL REFERENCES robot (name) ON UPDATE CASCADE ON DELETE CASCADE,  -- whose it is
    layer       TEXT    NOT NULL  -- by which a face's settings know it
        CHECK (layer GLOB '[a-z]*' AND layer NOT GLOB '*[^a-z0-9_]*' AND length(layer) <= 40),
    id          INTEGER NOT NULL  -- the servo's number on its bus
        CHECK (id BETWEEN 0 AND 253),
    name        TEXT    NOT NULL             -- for people
        CHECK (length(name) BETWEEN 1 AND 40),
    description TEXT    NOT NULL DEFAULT '',  -- for people
    initial     INTEGER NOT NULL  -- which position a face tells before it was moved
        CHECK (initial BETWEEN 0 AND 16383),
    lowest      INTEGER NOT NULL  -- which positions are taken; what is beyond is brought within
        CHECK (lowest BETWEEN 0 AND 16383),
    highest     INTEGER NOT NULL  -- see lowest
        CHECK (highest BETWEEN 0 AND 16383),
    rest        INTEGER NOT NULL  -- where it belongs
        CHECK (rest BETWEEN 0 AND 16383),
    inverted    INTEGER NOT NULL DEFAULT 0  -- 1: a percentage counts from its highest position down
        CHECK (inverted IN (0, 1)),
    builtin     INTEGER NOT NULL DEFAULT 0  -- 1: is changed here only, not from the network
        CHECK (builtin IN (0, 1)),
    PRIMARY KEY (robot, layer, id),
    CHECK (lowest < highest)
) STRICT
    """,
    """
CREATE TABLE button (
    robot   TEXT    NOT NULL REFERENCES robot (name) ON UPDATE CASCADE ON DELETE CASCADE,  -- whose it is
    id      INTEGER NOT NULL  -- the number
        CHECK (id BETWEEN 0 AND 9999),
    name    TEXT    NOT NULL             -- the name there; of several with the same, the lowest number is meant
        CHECK (length(name) BETWEEN 1 AND 40),
    button  TEXT    NOT NULL DEFAULT '',  -- what is written on the remote control's key
    motion  TEXT    NOT NULL DEFAULT '',  -- which motion is played; empty: none, only the controller is taken over
    builtin INTEGER NOT NULL DEFAULT 0   -- 1: is changed here only, not from the network
        CHECK (builtin IN (0, 1)),
    PRIMARY KEY (robot, id)
) STRICT
    """,
    """
CREATE TRIGGER motor_insert AFTER INSERT ON motor
BEGIN
    INSERT INTO revision (table_name, row_key, operation, old_row, new_row)
    VALUES ('motor', json_array(NEW.robot, NEW.layer, NEW.id), 'insert',
            NULL,
            json_object('robot', NEW.robot, 'layer', NEW.layer, 'id', NEW.id, 'name', NEW.name,
            'description', NEW.description, 'initial', NEW.initial, 'lowest', NEW.lowest, 'highest', NEW.highest,
            'rest', NEW.rest, 'inverted', NEW.inverted, 'builtin', NEW.builtin));
END;
    """,
    """
CREATE TRIGGER motor_update AFTER UPDATE ON motor
WHEN (OLD.robot, OLD.layer, OLD.id, OLD.name, OLD.description, OLD.initial, OLD.lowest, OLD.highest, OLD.rest, OLD.inverted, OLD.builtin)
     IS NOT (NEW.robot, NEW.layer, NEW.id, NEW.name, NEW.description, NEW.initial, NEW.lowest, NEW.highest, NEW.rest, NEW.inverted, NEW.builtin)
BEGIN
    INSERT INTO revision (table_name, row_key, operation, old_row, new_row)
    VALUES ('motor', json_array(NEW.robot, NEW.layer, NEW.id), 'update',
            json_object('robot', OLD.robot, 'layer', OLD.layer, 'id', OLD.id, 'name', OLD.name,
            'description', OLD.description, 'initial', OLD.initial, 'lowest', OLD.lowest, 'highest', OLD.highest,
            'rest', OLD.rest, 'inverted', OLD.inverted, 'builtin', OLD.builtin),
            json_object('robot', NEW.robot, 'layer', NEW.layer, 'id', NEW.id, 'name', NEW.name,
            'description', NEW.description, 'initial', NEW.initial, 'lowest', NEW.lowest, 'highest', NEW.highest,
            'rest', NEW.rest, 'inverted', NEW.inverted, 'builtin', NEW.builtin));
END;
    """,
    """
CREATE TRIGGER motor_delete AFTER DELETE ON motor
BEGIN
    INSERT INTO revision (table_name, row_key, operation, old_row, new_row)
    VALUES ('motor', json_array(OLD.robot, OLD.layer, OLD.id), 'delete',
            json_object('robot', OLD.robot, 'layer', OLD.layer, 'id', OLD.id, 'name', OLD.name,
            'description', OLD.description, 'initial', OLD.initial, 'lowest', OLD.lowest, 'highest', OLD.highest,
            'rest', OLD.rest, 'inverted', OLD.inverted, 'builtin', OLD.builtin),
            NULL);
END;
    """,
    """
CREATE TRIGGER button_insert AFTER INSERT ON button
BEGIN
    INSERT INTO revision (table_name, row_key, operation, old_row, new_row)
    VALUES ('button', json_array(NEW.robot, NEW.id), 'insert',
            NULL,
            json_object('robot', NEW.robot, 'id', NEW.id, 'name', NEW.name, 'button', NEW.button,
            'motion', NEW.motion, 'builtin', NEW.builtin));
END;
    """,
    """
CREATE TRIGGER button_update AFTER UPDATE ON button
WHEN (OLD.robot, OLD.id, OLD.name, OLD.button, OLD.motion, OLD.builtin)
     IS NOT (NEW.robot, NEW.id, NEW.name, NEW.button, NEW.motion, NEW.builtin)
BEGIN
    INSERT INTO revision (table_name, row_key, operation, old_row, new_row)
    VALUES ('button', json_array(NEW.robot, NEW.id), 'update',
            json_object('robot', OLD.robot, 'id', OLD.id, 'name', OLD.name, 'button', OLD.button,
            'motion', OLD.motion, 'builtin', OLD.builtin),
            json_object('robot', NEW.robot, 'id', NEW.id, 'name', NEW.name, 'button', NEW.button,
            'motion', NEW.motion, 'builtin', NEW.builtin));
END;
    """,
    """
CREATE TRIGGER button_delete AFTER DELETE ON button
BEGIN
    INSERT INTO revision (table_name, row_key, operation, old_row, new_row)
    VALUES ('button', json_array(OLD.robot, OLD.id), 'delete',
            json_object('robot', OLD.robot, 'id', OLD.id, 'name', OLD.name, 'button', OLD.button,
            'motion', OLD.motion, 'builtin', OLD.builtin),
            NULL);
END;
    """,
)


def upgrade() -> None:
    """Add columns and tables, and the triggers that keep the revisions."""
    for statement in STATEMENTS:
        op.execute(statement)


def downgrade() -> None:
    """Change nothing: an older database is kept as a backup whenever one is upgraded."""
