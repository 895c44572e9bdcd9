-- Adds proximity.py to the robot lbr. Put the program where argv says, and correct the paths to yours: argv names programs
-- by their full path, and the first must be a Python that has the package eclipse-zenoh.
PRAGMA foreign_keys = ON;
BEGIN;
INSERT INTO capability (robot, name, kind, settings, help) VALUES ('lbr', 'proximity', 'exec',
    '{"argv": ["/opt/proximity/bin/python", "/opt/proximity/proximity.py"], "inputs": ["ranges"], "outputs": ["nearest"],
      "ready": "token"}',
    'Publishes how near the nearest thing is');
INSERT INTO channel (robot, source, target) VALUES ('lbr', 'ranges.readings', 'proximity.ranges');
COMMIT;
