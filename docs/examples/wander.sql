-- Adds wander.py to the robot lbr: a capability, its two wires and a word that starts it.
PRAGMA foreign_keys = ON;
BEGIN;
INSERT INTO capability (robot, name, kind, settings, needs, help) VALUES
    ('lbr', 'wander', 'wander', '{"power": 0.25}', '["drive", "ranges"]', 'Drives about by itself');
INSERT INTO channel (robot, source, target) VALUES
    ('lbr', 'ranges.readings', 'wander.ranges'),
    ('lbr', 'wander.go', 'drive.command');
INSERT INTO verb (robot, word, pattern, target, help) VALUES
    ('lbr', 'wander', 'wander', 'wander.start', 'Drive about until somebody stops the robot');
COMMIT;
