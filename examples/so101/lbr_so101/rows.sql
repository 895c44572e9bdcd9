-- SO-101: two arms of six STS3215 each, a follower with torque and a leader that a hand moves.
-- Its rows. `lbr db init`, its first `lbr run` or `lbr db add so101` takes them into robot.db, where they are what it is.

INSERT INTO robot (name, model, description)
VALUES ('so101', 'SO-101', 'Two arms of six STS3215 servos: a leader that a hand moves, and a follower');

-- The addresses are examples: `ls /dev/serial/by-id` names the two boards.
INSERT INTO device (robot, name, type, address, settings) VALUES
    ('so101', 'follower_bus', 'feetech', '/dev/serial/by-id/usb-1a86_USB_Single_Serial_FOLLOWER-if00', '{}'),
    ('so101', 'leader_bus', 'feetech', '/dev/serial/by-id/usb-1a86_USB_Single_Serial_LEADER-if00', '{}');

INSERT INTO capability (robot, name, kind, settings, needs, help) VALUES
    ('so101', 'arm', 'feetech', '{"device": "follower_bus", "hold_s": 10.0}', '[]', 'The follower''s servos'),
    ('so101', 'leader_arm', 'feetech', '{"device": "leader_bus", "hold_s": 10.0}', '[]', 'The leader''s servos'),
    ('so101', 'joints', 'joints', '{"bus": "follower_bus"}', '["arm"]', 'The follower''s joints: who moves them'),
    ('so101', 'leader_joints', 'joints', '{"bus": "leader_bus"}', '["leader_arm"]', 'The leader''s joints'),
    ('so101', 'motions', 'motions', '{"bus": "follower_bus"}', '["joints"]', 'Plays and captures the follower''s poses'),
    ('so101', 'leader_motions', 'motions', '{"bus": "leader_bus"}', '["leader_joints"]',
     'Plays and captures the leader''s poses'),
    ('so101', 'teleop', 'teleop', '{"leader": "leader_", "bus": "follower_bus"}', '["joints", "leader_joints"]',
     'Has the follower go where the leader is'),
    ('so101', 'calibration', 'arm_calibration', '{"bus": "follower_bus"}', '["arm"]',
     'Learns where the follower''s joints are at 0, and how far they turn'),
    ('so101', 'leader_calibration', 'arm_calibration', '{"bus": "leader_bus"}', '["leader_arm"]', 'The same of the leader'),
    -- Torque, speed, current, friction and rotor as published for the follower's servos; the leader's gears are lighter.
    ('so101', 'world', 'humanoid_world',
     '{"model": "so101",
       "motor": {"stall_nm": 2.94, "no_load_rps": 5.2, "rated_v": 12.0, "friction_nm": 0.052, "armature_kgm2": 0.028,
                 "stall_a": 2.7},
       "rests": {"shoulder_lift": -1.745, "elbow_flex": 1.69, "wrist_flex": 0.6,
                 "leader_shoulder_lift": -1.745, "leader_elbow_flex": 1.69, "leader_wrist_flex": 0.6}}', '[]',
     'The simulated arms on their table; runs only under a simulating launch profile'),
    ('so101', 'web', 'web', '{"port": 50004, "faces": ["page", "model"]}', '[]',
     'The robot over HTTP: its page and API, stop; on this machine only, unless the settings say otherwise');

INSERT INTO channel (robot, source, target, history) VALUES
    ('so101', 'joints.setpoint', 'arm.setpoint', 1),
    ('so101', 'arm.state', 'joints.servos', 1),
    ('so101', 'joints.servos_recover', 'arm.recover', 1),
    ('so101', 'joints.state', 'motions.joints', 1),
    ('so101', 'joints.result', 'motions.ended', 4),
    ('so101', 'motions.move', 'joints.command', 1),
    ('so101', 'motions.halt', 'joints.stop', 1),
    ('so101', 'leader_joints.setpoint', 'leader_arm.setpoint', 1),
    ('so101', 'leader_arm.state', 'leader_joints.servos', 1),
    ('so101', 'leader_joints.servos_recover', 'leader_arm.recover', 1),
    ('so101', 'leader_joints.state', 'leader_motions.joints', 1),
    ('so101', 'leader_joints.result', 'leader_motions.ended', 4),
    ('so101', 'leader_motions.move', 'leader_joints.command', 1),
    ('so101', 'leader_motions.halt', 'leader_joints.stop', 1),
    ('so101', 'leader_joints.state', 'teleop.leader', 1),
    ('so101', 'joints.state', 'teleop.follower', 1),
    ('so101', 'teleop.move', 'joints.command', 1),
    ('so101', 'teleop.halt', 'joints.stop', 1),
    ('so101', 'arm.state', 'calibration.servos', 1),
    ('so101', 'leader_arm.state', 'leader_calibration.servos', 1),
    ('so101', 'joints.state', 'web.joints', 1),
    ('so101', 'leader_joints.state', 'web.joints', 1),
    ('so101', 'motions.state', 'web.motions', 1),
    ('so101', 'web.halt', 'joints.stop', 1),
    ('so101', 'web.halt', 'leader_joints.stop', 1),
    ('so101', 'web.stop_motion', 'motions.stop', 1),
    ('so101', 'web.stop_motion', 'leader_motions.stop', 1),
    ('so101', 'web.edit', 'executive.edit', 1),
    ('so101', 'web.estop_reset', 'executive.estop_reset', 1);

-- The words of the kinds mean the follower; these mean the leader.
INSERT INTO verb (robot, word, pattern, target, payload, role, help) VALUES
    ('so101', 'leader', '/leader/j/{joint}/{angle_deg}', 'leader_joints.move', NULL, 'operate',
     'Move a joint of the leader to an angle in degrees'),
    ('so101', 'leader', '/leader/torque/on', 'leader_joints.torque', '{"on": true}', 'operate',
     'Switch the leader''s torque on: each joint stays where it is'),
    ('so101', 'leader', '/leader/torque/off', 'leader_joints.torque', '{"on": false, "confirmed": true}', 'operate',
     'Switch the leader''s torque off, so that a hand can move it: it falls'),
    ('so101', 'leader', '/leader/play/{motion}', 'leader_motions.play', NULL, 'operate',
     'Play a pose of the leader, such as leader_ready'),
    ('so101', 'leader', '/leader/capture/{motion}', 'leader_motions.capture', NULL, 'admin',
     'Write the leader''s pose of now down under a name'),
    ('so101', 'leader', '/leader/calibrate/zero', 'leader_calibration.zero', NULL, 'admin',
     'Calibrate the leader: it is held at 0 now, every joint in the middle, the gripper closed'),
    ('so101', 'leader', '/leader/calibrate/done', 'leader_calibration.done', NULL, 'admin',
     'Every joint of the leader was moved to both ends: write it down');

-- Limits are the model's, a little within its ends. An uncalibrated arm is at 0 where its servos are in the middle.
INSERT INTO joint (robot, name, device_id, lower_rad, upper_rad, speed_rps, bus) VALUES
    ('so101', 'shoulder_pan', 1, -1.9, 1.9, 2.0, 'follower_bus'),
    ('so101', 'shoulder_lift', 2, -1.74, 1.74, 2.0, 'follower_bus'),
    ('so101', 'elbow_flex', 3, -1.69, 1.69, 2.0, 'follower_bus'),
    ('so101', 'wrist_flex', 4, -1.65, 1.65, 2.0, 'follower_bus'),
    ('so101', 'wrist_roll', 5, -2.74, 2.74, 2.0, 'follower_bus'),
    ('so101', 'gripper', 6, -0.17, 1.74, 2.0, 'follower_bus'),
    ('so101', 'leader_shoulder_pan', 1, -1.9, 1.9, 2.0, 'leader_bus'),
    ('so101', 'leader_shoulder_lift', 2, -1.74, 1.74, 2.0, 'leader_bus'),
    ('so101', 'leader_elbow_flex', 3, -1.69, 1.69, 2.0, 'leader_bus'),
    ('so101', 'leader_wrist_flex', 4, -1.65, 1.65, 2.0, 'leader_bus'),
    ('so101', 'leader_wrist_roll', 5, -2.74, 2.74, 2.0, 'leader_bus'),
    ('so101', 'leader_gripper', 6, -0.17, 1.74, 2.0, 'leader_bus');

INSERT INTO motion (robot, name, help) VALUES
    ('so101', 'rest', 'Lie folded on the table, where it may lose its torque'),
    ('so101', 'ready', 'Stand with the gripper ahead and open'),
    ('so101', 'stretched', 'Reach ahead as far as is good for the servos'),
    ('so101', 'leader_rest', 'The leader: lie folded'),
    ('so101', 'leader_ready', 'The leader: stand with the gripper ahead and open'),
    ('so101', 'leader_stretched', 'The leader: reach ahead');

INSERT INTO motion_step (robot, motion, step, duration_s, positions) VALUES
    ('so101', 'rest', 1, 2.5,
     '{"shoulder_pan": 0, "shoulder_lift": -1.74, "elbow_flex": 1.69, "wrist_flex": 0.6, "wrist_roll": 0, "gripper": 0}'),
    ('so101', 'ready', 1, 2.5,
     '{"shoulder_pan": 0, "shoulder_lift": -0.7, "elbow_flex": 0.7, "wrist_flex": 0.6, "wrist_roll": 0, "gripper": 0.8}'),
    ('so101', 'stretched', 1, 2.5,
     '{"shoulder_pan": 0.3, "shoulder_lift": 0.2, "elbow_flex": -0.4, "wrist_flex": 0.2, "wrist_roll": 0, "gripper": 0.3}'),
    ('so101', 'leader_rest', 1, 2.5,
     '{"leader_shoulder_pan": 0, "leader_shoulder_lift": -1.74, "leader_elbow_flex": 1.69, "leader_wrist_flex": 0.6,
       "leader_wrist_roll": 0, "leader_gripper": 0}'),
    ('so101', 'leader_ready', 1, 2.5,
     '{"leader_shoulder_pan": 0, "leader_shoulder_lift": -0.7, "leader_elbow_flex": 0.7, "leader_wrist_flex": 0.6,
       "leader_wrist_roll": 0, "leader_gripper": 0.8}'),
    ('so101', 'leader_stretched', 1, 2.5,
     '{"leader_shoulder_pan": 0.3, "leader_shoulder_lift": 0.2, "leader_elbow_flex": -0.4, "leader_wrist_flex": 0.2,
       "leader_wrist_roll": 0, "leader_gripper": 0.3}');
