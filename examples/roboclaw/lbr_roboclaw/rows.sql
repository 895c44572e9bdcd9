-- A small robot on two driven wheels and a caster, with a RoboClaw and nothing else.

INSERT INTO robot (name, model, description)
VALUES ('claw', 'two wheels', 'Drives on two wheels by a RoboClaw, without a sensor of distance');

-- The address is an example: `ls /dev/serial/by-id` names yours. A simulation does not need it.
INSERT INTO device (robot, name, type, address, settings) VALUES
    ('claw', 'motor_controller', 'roboclaw', '/dev/serial/by-id/usb-YOUR-roboclaw', '{"left_direction": -1}');

-- No rule names a sensor: nothing but its driver's eyes keeps it from a wall.
INSERT INTO capability (robot, name, kind, settings, needs, help) VALUES
    ('claw', 'motors', 'roboclaw',
     '{"device": "motor_controller", "left": {"channel": 1, "direction": -1}, "right": {"channel": 2}}',
     '[]', 'The motor controller: the left wheel on channel 1, mounted mirrored'),
    ('claw', 'drive', 'drive', '{"max_speed_mps": 0.6, "max_power": 0.5, "rules": []}', '["motors"]',
     'The base: who drives, and how fast'),
    ('claw', 'odometry', 'odometry', '{"max_speed_mps": 0.6}', '["motors"]', 'How far it went by its wheels'),
    ('claw', 'world', 'world', '{}', '[]', 'The simulated room; runs only under a simulating launch profile');

INSERT INTO channel (robot, source, target) VALUES
    ('claw', 'drive.setpoint', 'motors.setpoint'),
    ('claw', 'motors.state', 'drive.motors'),
    ('claw', 'motors.state', 'odometry.motors'),
    ('claw', 'odometry.state', 'drive.odometry');
