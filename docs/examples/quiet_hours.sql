-- Adds quiet_hours.py to the robot lbr, and has the drive ask it. The drive restarts for its new wiring.
PRAGMA foreign_keys = ON;
BEGIN;
INSERT INTO capability (robot, name, kind, settings, help) VALUES
    ('lbr', 'quiet_hours', 'quiet_hours', '{"begin": 22, "end": 7, "max_power": 0.2}',
     'Refuses fast driving during quiet hours');
INSERT INTO channel (robot, source, target) VALUES ('lbr', 'drive.checks', 'quiet_hours.check');
COMMIT;
