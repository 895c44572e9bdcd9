-- A rover on four driven wheels. The two motors of a side are on one channel of a Roboteq; it turns by skidding.
-- Its rows. `lbr db init`, its first `lbr run` or `lbr db add rover` takes them into robot.db, where they are what it is.

INSERT INTO robot (name, model, description)
VALUES ('rover', 'four wheels', 'Drives on four wheels, turns by skidding, and sees all around');

-- The addresses are examples: `ls /dev/serial/by-id` names yours. A simulation does not need them.
INSERT INTO device (robot, name, type, address) VALUES
    ('rover', 'motor_controller', 'roboteq', '/dev/serial/by-id/usb-YOUR-motor-controller'),
    ('rover', 'lidar_port', 'ld06', '/dev/serial/by-id/usb-YOUR-lidar'),
    ('rover', 'imu', 'mpu9150', 'i2c:1:0x68');

-- What the wheels do. They slip in a turn, and go 1.8 times as far as where they stand would make them: in the simulated world it
-- is 1.6 to 2 times. On your floor, turn once around by hand on the console and correct it until the odometry agrees.
INSERT INTO kinematics (robot, name, kind, track_factor) VALUES ('rover', 'base', 'skid', 1.8);
INSERT INTO wheel (robot, name, motor, x_m, y_m, diameter_m) VALUES
    ('rover', 'front_left', 'left', 0.13, 0.18, 0.15),
    ('rover', 'front_right', 'right', 0.13, -0.18, 0.15),
    ('rover', 'rear_left', 'left', -0.13, 0.18, 0.15),
    ('rover', 'rear_right', 'right', -0.13, -0.18, 0.15);

-- The lidar, on top of the deck, looks all around; the base stops 0.25 m before what it sees.
INSERT INTO range_sensor (robot, name, kind, x_m, z_m, fov_rad, min_m, max_m, rays, stop_m) VALUES
    ('rover', 'lidar', 'lidar', 0.05, 0.3, 6.2832, 0.02, 12, 360, 0.25);

-- What runs. `world` is the simulated room, and runs in a simulation alone. The full power of a spin makes 137 degrees a second:
-- twice 0.8 m/s, on a track of 0.36 m times 1.8. No rule of the drive names a sensor: the lidar's own row does.
INSERT INTO capability (robot, name, kind, settings, needs, help) VALUES
    ('rover', 'motors', 'roboteq',
     '{"device": "motor_controller", "left": {"channel": 1, "direction": -1}, "right": {"channel": 2, "direction": 1}}',
     '[]', 'The motor controller: the left wheels on channel 1, mounted mirrored, the right ones on channel 2'),
    ('rover', 'lidar', 'ld06', '{"device": "lidar_port"}', '[]', 'The lidar: distances all around'),
    ('rover', 'imu', 'mpu9150', '{"device": "imu"}', '[]', 'The inertial unit'),
    ('rover', 'drive', 'drive',
     '{"max_speed_mps": 0.8, "body_length_m": 0.45, "body_width_m": 0.42, "max_turn_dps": 137, "turn_power": 0.4,
       "turn_min_power": 0.1, "rules": []}',
     '["motors", "lidar"]', 'The base: who drives, how fast and how near to obstacles'),
    ('rover', 'attitude', 'attitude', '{"device": "imu"}', '["imu"]', 'How it lies, where it looks, how far it turned'),
    ('rover', 'odometry', 'odometry', '{"counts_per_turn": 400, "max_speed_mps": 0.8}', '["motors"]',
     'How far it went by its wheels, and whether they stall or slip'),
    ('rover', 'world', 'world',
     '{"body": {"length_m": 0.45, "width_m": 0.42, "height_m": 0.5, "mass_kg": 14, "wheel_diameter_m": 0.15,
                "counts_per_turn": 400, "max_speed_mps": 0.8}}',
     '[]', 'The simulated room; runs only under a simulating launch profile'),
    ('rover', 'web', 'web', '{"port": 50003, "faces": ["page", "model"]}', '[]',
     'The robot over HTTP: its page and API, stop; on this machine only, unless the settings say otherwise');

INSERT INTO channel (robot, source, target) VALUES
    ('rover', 'drive.setpoint', 'motors.setpoint'),
    ('rover', 'motors.state', 'drive.motors'),
    ('rover', 'lidar.scan', 'drive.scans'),
    ('rover', 'attitude.state', 'drive.attitude'),
    ('rover', 'odometry.state', 'drive.odometry'),
    ('rover', 'attitude.state', 'odometry.attitude'),
    ('rover', 'motors.state', 'odometry.motors'),
    ('rover', 'attitude.motion', 'drive.command'),
    ('rover', 'attitude.halt', 'drive.stop'),
    ('rover', 'drive.state', 'web.drive'),
    ('rover', 'web.halt', 'drive.stop'),
    ('rover', 'web.estop_reset', 'executive.estop_reset');
INSERT INTO channel (robot, source, target, history) VALUES ('rover', 'imu.sample', 'attitude.samples', 32);
