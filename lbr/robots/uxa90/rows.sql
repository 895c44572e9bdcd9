-- UXA-90: a humanoid of one metre, with a main board (UIC) that stores motions, and 25 SAM servos behind it.
-- `lbr db init`, its first `lbr run` or `lbr db add uxa90` copies these rows into robot.db. Afterwards this file is not read again.

INSERT INTO robot (name, model, description)
VALUES ('uxa90', 'UXA-90 Light', 'A humanoid of one metre: twenty-five servos behind a main board that keeps motions');

INSERT INTO device (robot, name, type, address, settings) VALUES
    ('uxa90', 'main_board', 'uxa90', 'by-id:usb-*-port0', '{}'),
    ('uxa90', 'head_camera', 'camera', '/dev/video0', '{}'),
    ('uxa90', 'speaker', 'speaker', 'alsa:default', '{}');

INSERT INTO capability (robot, name, kind, process, settings, needs, help) VALUES
    -- The inertial unit is asked in simulation alone: on a robot nobody has seen what it answers (docs/robots/uxa90.md).
    ('uxa90', 'servos', 'uxa90', '', '{"device": "main_board", "sweep_hz": 25, "imu": {"asked": "simulated"}}', '[]',
     'The serial line: the main board with its motions, and the servos behind it'),
    ('uxa90', 'joints', 'joints', '', '{"open_loop": true}', '["servos"]',
     'The joints: who moves them, how far and how fast'),
    ('uxa90', 'motions', 'motions', 'deeds', '{}', '["joints"]',
     'The motions: the main board''s own, and those of key frames'),
    ('uxa90', 'behaviour', 'behaviour', 'deeds', '{}', '["motions"]',
     'The behaviours: state tables that anyone can write, such as greet; one at a time'),
    ('uxa90', 'attitude', 'attitude', '', '{"device": "main_board", "gyro": false, "stale_s": 0.5}', '["servos"]',
     'The attitude: how the trunk lies, by the accelerations that the main board measures'),
    ('uxa90', 'camera_head', 'camera', '', '{"device": "head_camera", "width_px": 640, "height_px": 480, "on": true}', '[]',
     'The camera in the head'),
    ('uxa90', 'tracking', 'tracking', '', '{}', '["joints", "camera_head"]',
     'Tracking: the head follows a coloured thing'),
    ('uxa90', 'web', 'web', '', '{"faces": ["page", "model", "uxa90", "cameras", "recordings"]}', '[]',
     'The robot over HTTP: its page and API, its camera, the API of old; on this machine only, unless the settings say otherwise'),
    ('uxa90', 'world', 'humanoid_world', '',
     '{"model": "uxa90", "rests": {"left_hip_pitch": 1.78, "right_hip_pitch": 1.78, "left_knee": -2.4, "right_knee": -2.4,
                                   "left_ankle_pitch": 0.9, "right_ankle_pitch": 0.9},
       "motor": {"stall_nm": 2.9, "no_load_rps": 7.0, "rated_v": 18.5, "friction_nm": 0.12, "armature_kgm2": 0.004,
                 "stall_a": 2.0},
       "motors": [{"joints": ["*_ankle_*", "*_knee", "*_hip_pitch", "*_hip_roll"], "stall_nm": 20.6, "no_load_rps": 7.0,
                   "rated_v": 18.5, "friction_nm": 0.8, "armature_kgm2": 0.03, "stall_a": 10.0},
                  {"joints": ["*_hip_yaw", "waist_yaw"], "stall_nm": 15.7, "no_load_rps": 7.0, "rated_v": 18.5,
                   "friction_nm": 0.6, "armature_kgm2": 0.025, "stall_a": 8.0},
                  {"joints": ["*_shoulder_pitch", "*_shoulder_roll"], "stall_nm": 9.8, "no_load_rps": 7.0,
                   "rated_v": 18.5, "friction_nm": 0.4, "armature_kgm2": 0.015, "stall_a": 5.0}],
       "battery": {"open_circuit_v": 18.5, "internal_ohm": 0.02, "capacity_ah": 1000.0, "idle_a": 0.8, "charged_v": 18.6},
       "balls": {"ball": {"x_m": 1.5, "z_m": 0.65, "radius_m": 0.07, "path": "to_and_fro", "period_s": 10.0}}}', '[]',
     'The simulated body and floor; runs only under a simulating launch profile');

-- Always on, as for lbr.
INSERT INTO capability (robot, name, kind, settings, help) VALUES
    ('uxa90', 'box', 'box', '{}',
     'The black box: what was said of late, and for longer what led to an emergency stop, crash, fault, fall or mark');

-- Off: it needs `pip install 'lbr[foxglove]'`. Then `UPDATE capability SET enabled = 1 WHERE name = 'foxglove'`: docs/foxglove.md.
INSERT INTO capability (robot, name, kind, enabled, settings, help) VALUES
    ('uxa90', 'foxglove', 'foxglove', 0, '{"port": 8767}',
     'The robot for Foxglove: its streams, cameras, body and words, at ws://127.0.0.1:8767');

-- Off: it needs a gamepad at the robot's own computer, as for lbr. A motion goes on while the dead-man button is held.
INSERT INTO capability (robot, name, kind, enabled, settings, needs, help) VALUES
    ('uxa90', 'teleop', 'gamepad_teleop', 0,
     '{"lines": {"start": "/torque/on", "dpad_up": "/play/walk_forward_short", "dpad_left": "/play/turn_left",
                "dpad_right": "/play/turn_right", "a": "/play/reset"}}', '["motions"]',
     'The hand on a gamepad: plays motions while its dead-man button is held; a button stops');

-- Off: other machines cannot reach the robot, as for lbr.
INSERT INTO capability (robot, name, kind, enabled, settings, help) VALUES
    ('uxa90', 'lan', 'lan', 0, '{"listen": ["tls/0.0.0.0:7447"]}',
     'The door to other machines: whoever has a token comes in');

-- Off: the robot has no loudspeaker. With one: `UPDATE capability SET enabled = 1 WHERE name = 'speech'`.
INSERT INTO capability (robot, name, kind, enabled, settings, help) VALUES
    ('uxa90', 'speech', 'speech', 0, '{"device": "speaker"}',
     'The voice: says texts and phrases, and plays recordings');

-- Off: it needs `pip install 'lbr[mqtt]'`, a broker (the setting host) and for all but stop a token: docs/outside.md.
INSERT INTO capability (robot, name, kind, enabled, settings, help) VALUES
    ('uxa90', 'mqtt', 'mqtt', 0, '{"words": {"stop": {"do": "stop"}, "stand": {"do": "play", "motion": "reset"}}}',
     'The robot at a broker of MQTT: for Home Assistant, for a device shadow of AWS IoT; does what its words allow');

-- Off: it needs `pip install 'lbr[ros2]'`, ROS 2 on rmw_zenoh, and for all but looking and stops a token: docs/ros2.md.
INSERT INTO capability (robot, name, kind, enabled, settings, help) VALUES
    ('uxa90', 'ros2', 'ros2', 0, '{"services": {"stand": "/play/reset"}}',
     'The robot in ROS 2 by rmw_zenoh: joints, transforms, cameras and its body out; services in');

-- Off: it needs a registry (the setting url) and a token of it in credentials/registry.token: docs/registry.md.
INSERT INTO capability (robot, name, kind, enabled, settings, help) VALUES
    ('uxa90', 'registrar', 'registrar', 0, '{}',
     'Tells a registry that the robot is up, and how to reach it');

INSERT INTO channel (robot, source, target, history) VALUES
    ('uxa90', 'joints.setpoint', 'servos.setpoint', 1),
    ('uxa90', 'servos.state', 'joints.servos', 1),
    ('uxa90', 'joints.servos_recover', 'servos.recover', 1),
    ('uxa90', 'joints.state', 'motions.joints', 1),
    ('uxa90', 'joints.result', 'motions.ended', 4),
    ('uxa90', 'servos.imu', 'attitude.samples', 8),
    ('uxa90', 'attitude.state', 'motions.attitude', 1),
    ('uxa90', 'motions.move', 'joints.command', 1),
    ('uxa90', 'motions.halt', 'joints.stop', 1),
    ('uxa90', 'camera_head.frame', 'tracking.frame', 1),
    ('uxa90', 'camera_head.state', 'tracking.camera', 1),
    ('uxa90', 'joints.state', 'tracking.joints', 1),
    ('uxa90', 'tracking.move', 'joints.command', 1),
    ('uxa90', 'tracking.halt', 'joints.stop', 1),
    ('uxa90', 'joints.state', 'web.joints', 1),
    ('uxa90', 'motions.state', 'web.motions', 1),
    ('uxa90', 'joints.result', 'web.moved', 16),
    ('uxa90', 'motions.result', 'web.played', 16),
    ('uxa90', 'servos.controller', 'web.controller', 1),
    ('uxa90', 'camera_head.frame', 'web.frames', 2),
    ('uxa90', 'camera_head.frame', 'ros2.frames', 1),
    ('uxa90', 'camera_head.state', 'web.cameras', 4),
    ('uxa90', 'web.move', 'joints.command', 1),
    ('uxa90', 'web.halt', 'joints.stop', 1),
    ('uxa90', 'web.torque', 'joints.torque', 1),
    ('uxa90', 'web.play', 'motions.play', 1),
    ('uxa90', 'web.stop_motion', 'motions.stop', 1),
    ('uxa90', 'web.take_control', 'servos.take_control', 1),
    ('uxa90', 'web.edit', 'executive.edit', 1),
    ('uxa90', 'web.estop_reset', 'executive.estop_reset', 1),
    ('uxa90', 'teleop.say', 'executive.line', 1),
    ('uxa90', 'ros2.say', 'executive.line', 1);

-- A servo counts 0 to 254 over 269 degrees. Zeros are the factory's nominal ones. Signs of the legs come from published
-- kinematics, those of arms and head from the motions; waist, hip yaw and hands are guesses. Limits are the range of the
-- factory's motions and a little more, corrected where published tables swap left and right; none was measured. Speeds are
-- those of the factory's motions, and somewhat more for head and neck. Mirrored joints count alike: equal angles left and
-- right make a symmetrical pose. At zero it stands upright, arms down.
INSERT INTO joint (robot, name, device_id, side, sign, zero_rad, lower_rad, upper_rad, speed_rps) VALUES
    ('uxa90', 'left_ankle_roll', 0, 'left', -1, 0.0000, -0.333, 0.407, 1.3),
    ('uxa90', 'right_ankle_roll', 1, 'right', 1, 0.0000, -0.333, 0.407, 1.3),
    ('uxa90', 'left_ankle_pitch', 2, 'left', -1, 0.0000, -0.888, 0.925, 1.3),
    ('uxa90', 'right_ankle_pitch', 3, 'right', 1, 0.0000, -0.888, 0.925, 1.3),
    ('uxa90', 'left_knee', 4, 'left', -1, -1.4602, -2.440, 0.074, 3.0),
    ('uxa90', 'right_knee', 5, 'right', 1, 1.4602, -2.440, 0.074, 3.0),
    ('uxa90', 'left_hip_pitch', 6, 'left', 1, 0.0000, -0.278, 1.812, 1.9),
    ('uxa90', 'right_hip_pitch', 7, 'right', -1, 0.0000, -0.278, 1.812, 1.9),
    ('uxa90', 'left_hip_roll', 8, 'left', -1, 0.0000, -0.352, 0.463, 1.5),
    ('uxa90', 'right_hip_roll', 9, 'right', 1, 0.0000, -0.352, 0.463, 1.5),
    ('uxa90', 'left_hip_yaw', 10, 'left', 1, 0.0000, -0.370, 0.370, 1.6),
    ('uxa90', 'right_hip_yaw', 11, 'right', -1, 0.0000, -0.370, 0.370, 1.6),
    ('uxa90', 'left_shoulder_pitch', 12, 'left', 1, -0.8687, -0.555, 3.217, 5.7),
    ('uxa90', 'right_shoulder_pitch', 13, 'right', -1, 0.8687, -0.555, 3.198, 5.7),
    ('uxa90', 'left_shoulder_roll', 14, 'left', 1, 0.1848, -0.481, 2.163, 3.7),
    ('uxa90', 'right_shoulder_roll', 15, 'right', -1, -0.1848, -0.481, 2.145, 3.7),
    ('uxa90', 'left_shoulder_yaw', 16, 'left', 1, 0.0000, -2.329, 2.348, 5.3),
    ('uxa90', 'right_shoulder_yaw', 17, 'right', -1, 0.0000, -2.348, 2.329, 5.3),
    ('uxa90', 'left_elbow', 18, 'left', 1, 1.4602, -2.440, 0.148, 6.3),
    ('uxa90', 'right_elbow', 19, 'right', -1, -1.4602, -2.440, 0.148, 6.3),
    ('uxa90', 'left_hand', 20, 'left', 1, 0.0000, -0.370, 0.370, 5.3),
    ('uxa90', 'right_hand', 21, 'right', -1, 0.0000, -0.370, 0.370, 5.3),
    ('uxa90', 'waist_yaw', 22, 'centre', 1, 0.0000, -0.684, 0.795, 1.6),
    ('uxa90', 'neck_yaw', 23, 'centre', -1, 0.0000, -2.348, 2.329, 4.1),
    ('uxa90', 'head_pitch', 24, 'centre', 1, 0.0000, -0.832, 0.925, 3.0);

-- Motions that the main board plays by itself; rows of `button` have their names for people. Each robot may store another
-- motion under a number: check yours, and its duration. Key frames show where a motion leads.
INSERT INTO motion (robot, name, help, slot, slot_s, limp, builtin) VALUES
    ('uxa90', 'basic_motion', 'Take the walking stance', 1, 0.4, 0, 1),
    ('uxa90', 'kick_right', 'Kick with the right foot', 2, 11.1, 0, 1),
    ('uxa90', 'turn_left', 'Turn left on the spot, one step', 3, 1.5, 0, 1),
    ('uxa90', 'walk_forward_short', 'Walk ahead, one step', 4, 1.9, 0, 1),
    ('uxa90', 'turn_right', 'Turn right on the spot, one step', 5, 1.7, 0, 1),
    ('uxa90', 'walk_left', 'Step to the left', 6, 2.4, 0, 1),
    ('uxa90', 'reset', 'Stand up straight; the remote control''s red square, which some call stop: it stops nothing', 7, 7, 0, 1),
    ('uxa90', 'walk_right', 'Step to the right', 8, 2.5, 0, 1),
    ('uxa90', 'walk_forward_4step', 'Walk ahead, four steps', 9, 3.1, 0, 1),
    ('uxa90', 'basic_motion_down', 'What the remote control''s arrow down plays: as basic_motion, on some robots a step back', 10, 0.4, 0, 1),
    ('uxa90', 'walk_forward_6step', 'Walk ahead, six steps; on some robots four', 11, 5.7, 0, 1),
    ('uxa90', 'demo_introduction', 'Introduce itself with gestures', 12, 27.6, 0, 1),
    ('uxa90', 'dance_gangnamstyle', 'Dance', 13, 93.5, 0, 1),
    ('uxa90', 'sit_down', 'Sit down; the servos are let go at the end', 21, 7, 1, 1);

INSERT INTO motion_step (robot, motion, step, duration_s, stable, positions) VALUES
    ('uxa90', 'basic_motion', 1, 0.4, 1,
     '{"left_ankle_roll": 0.037, "right_ankle_roll": 0, "left_ankle_pitch": 0.462, "right_ankle_pitch": 0.425,
      "left_knee": -0.758, "right_knee": -0.739, "left_hip_pitch": 0.351, "right_hip_pitch": 0.333,
      "left_hip_roll": 0, "right_hip_roll": 0, "left_hip_yaw": 0, "right_hip_yaw": 0,
      "left_shoulder_pitch": -0.314, "right_shoulder_pitch": -0.314, "left_shoulder_roll": 0,
      "right_shoulder_roll": 0, "left_shoulder_yaw": 0.074, "right_shoulder_yaw": 0.074, "left_elbow": -0.591,
      "right_elbow": -0.591, "left_hand": 0, "right_hand": 0, "waist_yaw": 0, "neck_yaw": 0, "head_pitch": 0}'),
    ('uxa90', 'reset', 1, 7, 1,
     '{"left_ankle_roll": 0, "right_ankle_roll": 0, "left_ankle_pitch": 0, "right_ankle_pitch": 0, "left_knee": 0,
      "right_knee": 0, "left_hip_pitch": 0, "right_hip_pitch": 0, "left_hip_roll": 0, "right_hip_roll": 0,
      "left_hip_yaw": 0, "right_hip_yaw": 0, "left_shoulder_pitch": 0, "right_shoulder_pitch": 0,
      "left_shoulder_roll": 0, "right_shoulder_roll": 0, "left_shoulder_yaw": 0, "right_shoulder_yaw": 0,
      "left_elbow": 0, "right_elbow": 0, "left_hand": 0, "right_hand": 0, "waist_yaw": 0, "neck_yaw": 0,
      "head_pitch": 0}');

-- Walks and the kick end in the stance that they begin with. After a stop on its way, the robot goes straight there, if it may:
-- in simulation it then falls less often than a robot that is held at once. Check where yours end.
INSERT INTO motion_step (robot, motion, step, duration_s, stable, positions)
SELECT 'uxa90', motion.name, 1, motion.slot_s, 1, stance.positions
FROM motion JOIN motion_step AS stance ON stance.robot = 'uxa90' AND stance.motion = 'basic_motion'
WHERE motion.robot = 'uxa90' AND motion.name IN ('turn_left', 'walk_forward_short', 'turn_right', 'walk_left', 'walk_right',
                                                 'walk_forward_4step', 'walk_forward_6step', 'kick_right');

-- These motions come from experiments with the simulated body; nobody has tried them on a robot. As it gets up, its arms are
-- turned so that the weak elbows cannot fold. Stopped in one of these frames, the simulated body does not fall: it is on the
-- ground, on hands and feet, or on its feet.
INSERT INTO motion (robot, name, help, lead_out) VALUES
    ('uxa90', 'get_up_face', 'Get up after a fall, lying on its face: hands ahead, up on hands and feet, upright', ''),
    ('uxa90', 'get_up_back', 'Get up after a fall, lying on its back: over its right side onto its face, and up', 'get_up_face'),
    ('uxa90', 'get_up_side', 'Get up after a fall, lying on either side: over onto its face, and up', 'get_up_face');

INSERT INTO motion_step (robot, motion, step, duration_s, stable, positions) VALUES
    ('uxa90', 'get_up_face', 1, 1.000, 1,
     '{"left_hip_pitch": 0, "right_hip_pitch": 0, "left_knee": 0, "right_knee": 0, "left_ankle_pitch": -0.6,
      "right_ankle_pitch": -0.6, "left_shoulder_pitch": 0, "right_shoulder_pitch": 0, "left_shoulder_roll": 1.55,
      "right_shoulder_roll": 1.55, "left_elbow": 0, "right_elbow": 0, "left_hip_roll": 0, "right_hip_roll": 0,
      "left_hip_yaw": 0, "right_hip_yaw": 0, "left_ankle_roll": 0, "right_ankle_roll": 0, "left_shoulder_yaw": 0,
      "right_shoulder_yaw": 0, "left_hand": 0, "right_hand": 0, "waist_yaw": 0, "neck_yaw": 0, "head_pitch": -0.8}'),
    ('uxa90', 'get_up_face', 2, 1.200, 1,
     '{"left_hip_pitch": 0, "right_hip_pitch": 0, "left_knee": 0, "right_knee": 0, "left_ankle_pitch": -0.6,
      "right_ankle_pitch": -0.6, "left_shoulder_pitch": 3, "right_shoulder_pitch": 3, "left_shoulder_roll": 1.55,
      "right_shoulder_roll": 1.55, "left_elbow": 0, "right_elbow": 0}'),
    ('uxa90', 'get_up_face', 3, 1.000, 1,
     '{"left_hip_pitch": 0, "right_hip_pitch": 0, "left_knee": 0, "right_knee": 0, "left_ankle_pitch": -0.3,
      "right_ankle_pitch": -0.3, "left_shoulder_pitch": 3, "right_shoulder_pitch": 3, "left_shoulder_roll": 0.1,
      "right_shoulder_roll": 0.1, "left_elbow": 0, "right_elbow": 0, "left_shoulder_yaw": 1.9,
      "right_shoulder_yaw": 1.9}'),
    ('uxa90', 'get_up_face', 4, 1.430, 1,
     '{"left_hip_pitch": 0.93, "right_hip_pitch": 0.93, "left_knee": -0.5, "right_knee": -0.5,
      "left_ankle_pitch": 0.88, "right_ankle_pitch": 0.88, "left_shoulder_pitch": 2.64, "right_shoulder_pitch": 2.64,
      "left_shoulder_roll": 0.05, "right_shoulder_roll": 0.05, "left_elbow": 0.09, "right_elbow": 0.09}'),
    ('uxa90', 'get_up_face', 5, 1.150, 1,
     '{"left_hip_pitch": 1.68, "right_hip_pitch": 1.68, "left_knee": -0.28, "right_knee": -0.28,
      "left_ankle_pitch": 0.68, "right_ankle_pitch": 0.68, "left_shoulder_pitch": 2.54, "right_shoulder_pitch": 2.54,
      "left_shoulder_roll": 0.05, "right_shoulder_roll": 0.05, "left_elbow": 0.09, "right_elbow": 0.09}'),
    ('uxa90', 'get_up_face', 6, 1.140, 1,
     '{"left_hip_pitch": 1.76, "right_hip_pitch": 1.76, "left_knee": 0.05, "right_knee": 0.05,
      "left_ankle_pitch": 0.27, "right_ankle_pitch": 0.27, "left_shoulder_pitch": 2.15, "right_shoulder_pitch": 2.15,
      "left_shoulder_roll": 0.05, "right_shoulder_roll": 0.05, "left_elbow": 0.09, "right_elbow": 0.09}'),
    ('uxa90', 'get_up_face', 7, 1.190, 1,
     '{"left_hip_pitch": 1.66, "right_hip_pitch": 1.66, "left_knee": -0.05, "right_knee": -0.05,
      "left_ankle_pitch": 0.25, "right_ankle_pitch": 0.25, "left_shoulder_pitch": 1.82, "right_shoulder_pitch": 1.82,
      "left_shoulder_roll": 0.05, "right_shoulder_roll": 0.05, "left_elbow": 0.09, "right_elbow": 0.09}'),
    ('uxa90', 'get_up_face', 8, 1.440, 1,
     '{"left_hip_pitch": 1.78, "right_hip_pitch": 1.78, "left_knee": 0, "right_knee": 0, "left_ankle_pitch": 0.36,
      "right_ankle_pitch": 0.36, "left_shoulder_pitch": 1.78, "right_shoulder_pitch": 1.78,
      "left_shoulder_roll": 0.05, "right_shoulder_roll": 0.05, "left_elbow": 0.09, "right_elbow": 0.09}'),
    ('uxa90', 'get_up_face', 9, 0.750, 1,
     '{"left_hip_pitch": 1.78, "right_hip_pitch": 1.78, "left_knee": 0.06, "right_knee": 0.06,
      "left_ankle_pitch": -0.17, "right_ankle_pitch": -0.17, "left_shoulder_pitch": 1.87,
      "right_shoulder_pitch": 1.87, "left_shoulder_roll": 0.05, "right_shoulder_roll": 0.05, "left_elbow": 0.09,
      "right_elbow": 0.09}'),
    ('uxa90', 'get_up_face', 10, 0.620, 1,
     '{"left_hip_pitch": 1.32, "right_hip_pitch": 1.32, "left_knee": 0.06, "right_knee": 0.06,
      "left_ankle_pitch": -0.3, "right_ankle_pitch": -0.3, "left_shoulder_pitch": 1.33, "right_shoulder_pitch": 1.33,
      "left_shoulder_roll": 0.1, "right_shoulder_roll": 0.1, "left_elbow": 0.09, "right_elbow": 0.09}'),
    ('uxa90', 'get_up_face', 11, 1.500, 1,
     '{"left_hip_pitch": 0, "right_hip_pitch": 0, "left_knee": 0, "right_knee": 0, "left_ankle_pitch": 0,
      "right_ankle_pitch": 0, "left_shoulder_pitch": 0, "right_shoulder_pitch": 0, "left_shoulder_roll": 0.1,
      "right_shoulder_roll": 0.1, "left_elbow": 0, "right_elbow": 0, "left_shoulder_yaw": 0, "right_shoulder_yaw": 0,
      "head_pitch": 0}'),
    ('uxa90', 'get_up_back', 1, 1.600, 1,
     '{"left_hip_pitch": 1.5, "right_hip_pitch": 1.5, "left_knee": -1.2, "right_knee": -1.2, "left_hip_yaw": 0,
      "right_hip_yaw": 0, "left_hip_roll": 0, "right_hip_roll": 0, "left_shoulder_pitch": -0.54,
      "left_shoulder_roll": 0.5, "right_shoulder_pitch": 3, "right_shoulder_roll": 0, "waist_yaw": 0,
      "left_ankle_pitch": 0, "right_ankle_pitch": 0, "left_ankle_roll": 0, "right_ankle_roll": 0, "left_hand": 0,
      "right_hand": 0, "neck_yaw": 0, "head_pitch": 0, "left_shoulder_yaw": 0, "right_shoulder_yaw": 0,
      "left_elbow": 0, "right_elbow": 0}'),
    ('uxa90', 'get_up_back', 2, 1.000, 1,
     '{"left_hip_pitch": 1.5, "right_hip_pitch": 1.5, "left_knee": -1.2, "right_knee": -1.2, "left_hip_yaw": -0.35,
      "right_hip_yaw": 0.35, "left_shoulder_pitch": -0.54, "left_shoulder_roll": 0.5, "waist_yaw": 0.68}'),
    ('uxa90', 'get_up_back', 3, 1.000, 1,
     '{"left_hip_pitch": 1.5, "right_hip_pitch": 1.5, "left_knee": -1.2, "right_knee": -1.2,
      "left_shoulder_pitch": 1.6, "left_shoulder_roll": -0.2, "waist_yaw": 0.68}'),
    ('uxa90', 'get_up_back', 4, 1.430, 1,
     '{"left_hip_pitch": 1.2, "right_hip_pitch": 1.2, "left_knee": -0.6, "right_knee": -0.6, "left_hip_yaw": 0,
      "right_hip_yaw": 0, "left_shoulder_pitch": 1.6, "left_shoulder_roll": -0.2, "waist_yaw": -0.66}'),
    ('uxa90', 'get_up_back', 5, 1.100, 1,
     '{"left_shoulder_pitch": 1.57, "left_shoulder_roll": -0.18, "left_hip_pitch": 1.13, "left_knee": -0.76,
      "left_hip_roll": -0.16, "left_hip_yaw": -0.02, "right_shoulder_pitch": 3.08, "right_shoulder_roll": 0.01,
      "right_hip_pitch": 0.02, "right_knee": -0.26, "right_hip_roll": 0.03, "right_hip_yaw": -0.08,
      "waist_yaw": -0.51, "left_ankle_pitch": -0.8, "right_ankle_pitch": -0.8}'),
    ('uxa90', 'get_up_back', 6, 1.090, 1,
     '{"left_shoulder_pitch": 1.93, "left_shoulder_roll": -0.33, "left_hip_pitch": 1.64, "left_knee": -0.18,
      "left_hip_roll": -0.16, "left_hip_yaw": -0.01, "right_shoulder_pitch": 3.06, "right_shoulder_roll": 0.11,
      "right_hip_pitch": -0.22, "right_knee": 0.02, "right_hip_roll": 0.02, "right_hip_yaw": 0.04, "waist_yaw": -0.59,
      "left_ankle_pitch": -0.8, "right_ankle_pitch": -0.8}'),
    ('uxa90', 'get_up_back', 7, 1.160, 1,
     '{"left_shoulder_pitch": 2.59, "left_shoulder_roll": 0.46, "left_hip_pitch": 0.46, "left_knee": -0.42,
      "left_hip_roll": -0.16, "left_hip_yaw": -0.03, "right_shoulder_pitch": 3.03, "right_shoulder_roll": 0.34,
      "right_hip_pitch": -0.14, "right_knee": -0.48, "right_hip_roll": 0.03, "right_hip_yaw": -0.04,
      "waist_yaw": 0.03, "left_ankle_pitch": -0.8, "right_ankle_pitch": -0.8}'),
    ('uxa90', 'get_up_back', 8, 1.400, 1,
     '{"left_hip_pitch": 0, "right_hip_pitch": 0, "left_knee": 0, "right_knee": 0, "left_ankle_pitch": -0.6,
      "right_ankle_pitch": -0.6, "left_shoulder_pitch": 2.9, "right_shoulder_pitch": 2.9, "left_shoulder_roll": 0.5,
      "right_shoulder_roll": 0.5, "left_elbow": 0, "right_elbow": 0, "left_hip_roll": 0, "right_hip_roll": 0,
      "waist_yaw": 0, "left_hip_yaw": 0, "right_hip_yaw": 0}'),
    ('uxa90', 'get_up_side', 1, 0.740, 1,
     '{"left_shoulder_pitch": -0.07, "right_shoulder_pitch": -0.07, "left_shoulder_roll": -0.45,
      "right_shoulder_roll": -0.45, "left_elbow": -1.41, "right_elbow": -1.41, "left_hip_pitch": -0.26,
      "right_hip_pitch": -0.26, "left_knee": -0.11, "right_knee": -0.11, "left_hip_roll": 0.03,
      "right_hip_roll": 0.03, "left_shoulder_yaw": 0.24, "right_shoulder_yaw": 0.24, "left_hip_yaw": 0,
      "right_hip_yaw": 0, "left_ankle_pitch": 0, "right_ankle_pitch": 0, "left_ankle_roll": 0, "right_ankle_roll": 0,
      "left_hand": 0, "right_hand": 0, "waist_yaw": 0, "neck_yaw": 0, "head_pitch": 0}'),
    ('uxa90', 'get_up_side', 2, 1.260, 1,
     '{"left_shoulder_pitch": 1.91, "right_shoulder_pitch": 1.91, "left_shoulder_roll": -0.46,
      "right_shoulder_roll": -0.46, "left_elbow": -0.25, "right_elbow": -0.25, "left_hip_pitch": -0.26,
      "right_hip_pitch": -0.26, "left_knee": -1.47, "right_knee": -1.47, "left_hip_roll": 0.06,
      "right_hip_roll": 0.06, "left_shoulder_yaw": -0.29, "right_shoulder_yaw": -0.29}'),
    ('uxa90', 'get_up_side', 3, 0.930, 1,
     '{"left_shoulder_pitch": -0.54, "right_shoulder_pitch": -0.54, "left_shoulder_roll": 0.08,
      "right_shoulder_roll": 0.08, "left_elbow": -0.06, "right_elbow": -0.06, "left_hip_pitch": 0.81,
      "right_hip_pitch": 0.81, "left_knee": -0.86, "right_knee": -0.86, "left_hip_roll": 0.44, "right_hip_roll": 0.44,
      "left_shoulder_yaw": -0.23, "right_shoulder_yaw": -0.23}'),
    ('uxa90', 'get_up_side', 4, 1.500, 1,
     '{"left_hip_pitch": 0, "right_hip_pitch": 0, "left_knee": 0, "right_knee": 0, "left_ankle_pitch": -0.6,
      "right_ankle_pitch": -0.6, "left_shoulder_pitch": 0, "right_shoulder_pitch": 0, "left_shoulder_roll": 1.55,
      "right_shoulder_roll": 1.55, "left_elbow": 0, "right_elbow": 0, "left_shoulder_yaw": 0, "right_shoulder_yaw": 0,
      "left_hip_roll": 0, "right_hip_roll": 0}');

-- Three layers of the servos. `api`: the old table of phones and scripts, with its errors (knees and left shoulder are those
-- of the other side). `factory`: the range of the factory's motions. `safe`: the limits of the joints.
INSERT INTO motor (robot, layer, id, name, description, initial, lowest, highest, rest, inverted, builtin) VALUES
    ('uxa90', 'api', 0, 'left-foot', 'foot tilt in/out', 127, 115, 140, 127, 1, 1),
    ('uxa90', 'api', 1, 'right-foot', 'foot tilt in/out', 127, 110, 140, 127, 0, 1),
    ('uxa90', 'api', 2, 'left-heel', 'foot up/down', 127, 77, 175, 127, 1, 1),
    ('uxa90', 'api', 3, 'right-heel', 'foot up/down', 127, 78, 175, 127, 0, 1),
    ('uxa90', 'api', 4, 'left-knee', 'shin front/back', 204, 77, 204, 204, 1, 1),
    ('uxa90', 'api', 5, 'right-knee', 'shin fron/back', 50, 50, 180, 50, 0, 1),
    ('uxa90', 'api', 6, 'left-front-upper-leg', '', 127, 0, 255, 127, 1, 1),
    ('uxa90', 'api', 7, 'right-front-upper-leg', '', 127, 0, 255, 127, 0, 1),
    ('uxa90', 'api', 8, 'left-back-upper-leg', '', 127, 0, 255, 127, 1, 1),
    ('uxa90', 'api', 9, 'right-back-upper-leg', '', 127, 0, 255, 127, 0, 1),
    ('uxa90', 'api', 10, 'left-hip', '', 127, 0, 255, 127, 1, 1),
    ('uxa90', 'api', 11, 'right-hip', '', 127, 0, 255, 127, 0, 1),
    ('uxa90', 'api', 12, 'left-upper-shoulder', '', 180, 10, 254, 180, 1, 1),
    ('uxa90', 'api', 13, 'right-upper-shoulder', '', 180, 1, 254, 180, 0, 1),
    ('uxa90', 'api', 14, 'left-lower-shoulder', '', 115, 135, 254, 135, 0, 1),
    ('uxa90', 'api', 15, 'right-lower-shoulder', '', 138, 1, 120, 120, 1, 1),
    ('uxa90', 'api', 16, 'left-bicep', 'twist in', 127, 1, 254, 127, 1, 1),
    ('uxa90', 'api', 17, 'right-arm', 'twist in', 127, 1, 254, 127, 0, 1),
    ('uxa90', 'api', 18, 'left-eblow', 'max is up', 210, 75, 210, 210, 1, 1),
    ('uxa90', 'api', 19, 'right-elbow', 'min is up', 40, 40, 180, 40, 0, 1),
    ('uxa90', 'api', 22, 'hip', 'rotate left/right', 127, 95, 165, 127, 0, 1),
    ('uxa90', 'api', 23, 'neck', 'look left/right', 127, 1, 254, 127, 0, 1),
    ('uxa90', 'api', 24, 'head', 'look up/down', 127, 100, 160, 127, 0, 1),
    ('uxa90', 'factory', 0, 'left-ankle-roll', '', 127, 111, 140, 127, 1, 1),
    ('uxa90', 'factory', 1, 'right-ankle-roll', '', 127, 114, 140, 127, 0, 1),
    ('uxa90', 'factory', 2, 'left-ankle-pitch', '', 127, 87, 127, 127, 1, 1),
    ('uxa90', 'factory', 3, 'right-ankle-pitch', '', 127, 127, 165, 127, 0, 1),
    ('uxa90', 'factory', 4, 'left-knee', '', 48, 48, 129, 48, 1, 1),
    ('uxa90', 'factory', 5, 'right-knee', '', 206, 126, 206, 206, 0, 1),
    ('uxa90', 'factory', 6, 'left-hip-pitch', '', 127, 122, 166, 127, 1, 1),
    ('uxa90', 'factory', 7, 'right-hip-pitch', '', 127, 89, 133, 127, 0, 1),
    ('uxa90', 'factory', 8, 'left-hip-roll', '', 127, 112, 136, 127, 1, 1),
    ('uxa90', 'factory', 9, 'right-hip-roll', '', 127, 118, 140, 127, 0, 1),
    ('uxa90', 'factory', 10, 'left-hip-yaw', '', 127, 127, 137, 127, 1, 1),
    ('uxa90', 'factory', 11, 'right-hip-yaw', '', 127, 117, 127, 127, 0, 1),
    ('uxa90', 'factory', 12, 'left-shoulder-pitch', '', 80, 52, 243, 80, 1, 1),
    ('uxa90', 'factory', 13, 'right-shoulder-pitch', '', 174, 11, 191, 174, 0, 1),
    ('uxa90', 'factory', 14, 'left-shoulder-roll', '', 137, 121, 201, 137, 0, 1),
    ('uxa90', 'factory', 15, 'right-shoulder-roll', '', 117, 36, 140, 117, 1, 1),
    ('uxa90', 'factory', 16, 'left-shoulder-yaw', '', 127, 26, 156, 127, 1, 1),
    ('uxa90', 'factory', 17, 'right-shoulder-yaw', '', 127, 91, 221, 127, 0, 1),
    ('uxa90', 'factory', 18, 'left-elbow', '', 206, 97, 208, 206, 1, 1),
    ('uxa90', 'factory', 19, 'right-elbow', '', 48, 40, 160, 48, 0, 1),
    ('uxa90', 'factory', 20, 'left-hand', '', 127, 117, 136, 127, 0, 1),
    ('uxa90', 'factory', 21, 'right-hand', '', 127, 115, 127, 127, 0, 1),
    ('uxa90', 'factory', 22, 'waist-yaw', '', 127, 107, 151, 127, 0, 1),
    ('uxa90', 'factory', 23, 'neck-yaw', '', 127, 69, 179, 127, 0, 1),
    ('uxa90', 'factory', 24, 'head-pitch', '', 127, 92, 177, 127, 0, 1),
    ('uxa90', 'safe', 0, 'left-ankle-roll', '', 127, 105, 145, 127, 1, 1),
    ('uxa90', 'safe', 1, 'right-ankle-roll', '', 127, 109, 149, 127, 0, 1),
    ('uxa90', 'safe', 2, 'left-ankle-pitch', '', 127, 77, 175, 127, 1, 1),
    ('uxa90', 'safe', 3, 'right-ankle-pitch', '', 127, 79, 177, 127, 0, 1),
    ('uxa90', 'safe', 4, 'left-knee', '', 48, 44, 180, 48, 1, 1),
    ('uxa90', 'safe', 5, 'right-knee', '', 206, 74, 210, 206, 0, 1),
    ('uxa90', 'safe', 6, 'left-hip-pitch', '', 127, 112, 176, 127, 1, 1),
    ('uxa90', 'safe', 7, 'right-hip-pitch', '', 127, 79, 143, 127, 0, 1),
    ('uxa90', 'safe', 8, 'left-hip-roll', '', 127, 102, 146, 127, 1, 1),
    ('uxa90', 'safe', 9, 'right-hip-roll', '', 127, 108, 150, 127, 0, 1),
    ('uxa90', 'safe', 10, 'left-hip-yaw', '', 127, 117, 147, 127, 1, 1),
    ('uxa90', 'safe', 11, 'right-hip-yaw', '', 127, 107, 137, 127, 0, 1),
    ('uxa90', 'safe', 12, 'left-shoulder-pitch', '', 80, 50, 254, 80, 1, 1),
    ('uxa90', 'safe', 13, 'right-shoulder-pitch', '', 174, 1, 204, 174, 0, 1),
    ('uxa90', 'safe', 14, 'left-shoulder-roll', '', 137, 111, 254, 137, 0, 1),
    ('uxa90', 'safe', 15, 'right-shoulder-roll', '', 117, 1, 143, 117, 1, 1),
    ('uxa90', 'safe', 16, 'left-shoulder-yaw', '', 127, 1, 254, 127, 1, 1),
    ('uxa90', 'safe', 17, 'right-shoulder-yaw', '', 127, 1, 254, 127, 0, 1),
    ('uxa90', 'safe', 18, 'left-elbow', '', 206, 74, 214, 206, 1, 1),
    ('uxa90', 'safe', 19, 'right-elbow', '', 48, 40, 180, 48, 0, 1),
    ('uxa90', 'safe', 20, 'left-hand', '', 127, 107, 147, 127, 0, 1),
    ('uxa90', 'safe', 21, 'right-hand', '', 127, 107, 147, 127, 0, 1),
    ('uxa90', 'safe', 22, 'waist-yaw', '', 127, 90, 170, 127, 0, 1),
    ('uxa90', 'safe', 23, 'neck-yaw', '', 127, 1, 254, 127, 0, 1),
    ('uxa90', 'safe', 24, 'head-pitch', '', 127, 82, 177, 127, 0, 1);

-- The motions' numbers and names for phones and scripts.
INSERT INTO button (robot, id, name, button, motion, builtin) VALUES
    ('uxa90', 1, 'basic_motion', 'A', 'basic_motion', 1),
    ('uxa90', 2, 'kick_right', 'B', 'kick_right', 1),
    ('uxa90', 3, 'turn_left', 'LR', 'turn_left', 1),
    ('uxa90', 4, 'walk_forward_short', 'U', 'walk_forward_short', 1),
    ('uxa90', 5, 'turn_right', 'RR', 'turn_right', 1),
    ('uxa90', 6, 'walk_left', 'L', 'walk_left', 1),
    ('uxa90', 7, 'reset', 'S', 'reset', 1),
    ('uxa90', 8, 'walk_right', 'R', 'walk_right', 1),
    ('uxa90', 9, 'walk_foward_4step', 'LA', 'walk_forward_4step', 1),
    ('uxa90', 10, 'basic_motion', 'D', 'basic_motion_down', 1),
    ('uxa90', 11, 'walk_foward_6step', 'RA', 'walk_forward_6step', 1),
    ('uxa90', 12, 'demo_introduction', '1', 'demo_introduction', 1),
    ('uxa90', 13, 'dance_gangnamstyle', '2', 'dance_gangnamstyle', 1),
    ('uxa90', 21, 'sit_down', '0', 'sit_down', 1),
    ('uxa90', 99, 'pc_control', '', '', 1);

-- The kinds of its capabilities bring most of its words; a row with the same pattern replaces one.
INSERT INTO verb (robot, word, pattern, target, payload, role, help) VALUES
    ('uxa90', 'camera', '/camera/on', 'camera_head.switch', '{"on": true}', 'operate',
     'Switch the camera in the head on'),
    ('uxa90', 'camera', '/camera/off', 'camera_head.switch', '{"on": false}', 'operate',
     'Switch the camera in the head off'),
    ('uxa90', 'snapshot', 'snapshot', 'camera_head.snapshot', NULL, 'operate',
     'Save what the camera in the head sees as a picture, named after the time');

-- Behaviours: docs/examples/behaviours/uxa90 has the same tables for a spreadsheet; `lbr behaviour export` writes yours.
INSERT INTO behaviour (robot, name, help, max_s) VALUES
    ('uxa90', 'get_up', 'Get up after a fall: looks how it lies, plays the motion of that side, three times at most', 150),
    ('uxa90', 'greet', 'Stand up, say hello if it has a voice, and introduce itself', 120),
    ('uxa90', 'show', 'Steps, turns and a kick, each once, in an order by chance, with pauses; then the dance. Hold the tether', 300);

INSERT INTO behaviour_row (robot, behaviour, step, type, state, conditions, outputs, next_state, deadline_s) VALUES
    ('uxa90', 'get_up', 1, '#', 'Looks how it lies, plays the motion of that side, and looks again', '{}', '{}', '', NULL),
    ('uxa90', 'get_up', 2, 'start', 'Looking', '{"attitude.roll_rad": "-0.5:0.5 for 1 s", "attitude.pitch_rad": "-0.5:0.5 for 1 s"}', '{}', 'Upright', NULL),
    ('uxa90', 'get_up', 3, '', 'Looking', '{"Visits": "<= 3", "motions.fallen": "face for 1 s"}', '{"motion": "get_up_face"}', 'Rising', NULL),
    ('uxa90', 'get_up', 4, '', 'Looking', '{"Visits": "<= 3", "motions.fallen": "side for 1 s"}', '{"motion": "get_up_side"}', 'Rising', NULL),
    ('uxa90', 'get_up', 5, '', 'Looking', '{"Visits": "<= 3", "motions.fallen": "back for 1 s"}', '{"motion": "get_up_back"}', 'Rising', NULL),
    ('uxa90', 'get_up', 6, '', 'Looking', '{"attitude.roll_rad": "missing for 3 s"}', '{}', 'Blind', NULL),
    ('uxa90', 'get_up', 7, '', 'Looking', '{"Time": ">= 10"}', '{}', 'Not up', NULL),
    ('uxa90', 'get_up', 8, '', 'Rising', '{"Result": "done or fallen"}', '{}', 'Looking', NULL),
    ('uxa90', 'get_up', 9, '', 'Rising', '{}', '{}', 'Refused', NULL),
    ('uxa90', 'get_up', 10, 'end', 'Upright', '{}', '{}', '', NULL),
    ('uxa90', 'get_up', 11, 'fail', 'Not up', '{}', '{"speech": "I cannot get up. Please help me"}', '', NULL),
    ('uxa90', 'get_up', 12, 'fail', 'Refused', '{}', '{}', '', NULL),
    ('uxa90', 'get_up', 13, 'fail', 'Blind', '{}', '{}', '', NULL),
    ('uxa90', 'greet', 1, 'start', 'Looking', '{"joints.joints.left_knee.torque": "> 0", "joints.joints.left_knee.position_rad": "> -1.2"}', '{}', 'Standing', NULL),
    ('uxa90', 'greet', 2, '', 'Looking', '{"Time": ">= 1"}', '{"motion": "reset"}', 'Standing', NULL),
    ('uxa90', 'greet', 3, '', 'Standing', '{}', '{"motion": "demo_introduction", "speech": "Hello | Good day | Nice to see you"}', 'Greeted', NULL),
    ('uxa90', 'greet', 4, 'end', 'Greeted', '{}', '{}', '', NULL),
    ('uxa90', 'greet', 5, 'fail', 'Not greeted', '{}', '{}', '', NULL),
    ('uxa90', 'show', 1, '#', 'Steps, turns and a kick, each once, in an order by chance; then the dance', '{}', '{}', '', NULL),
    ('uxa90', 'show', 2, 'start', 'Looking', '{"joints.joints.left_knee.torque": "> 0", "joints.joints.left_knee.position_rad": "> -1.2"}', '{}', 'Choosing', NULL),
    ('uxa90', 'show', 3, '', 'Looking', '{"Time": ">= 1"}', '{"motion": "reset"}', 'Choosing', NULL),
    ('uxa90', 'show', 4, '', 'Choosing', '{"Chance": "< 20", "$left": "missing"}', '{"set": "left = 1", "motion": "walk_left", "wait": "1 | 2 | 3"}', 'Choosing', NULL),
    ('uxa90', 'show', 5, '', 'Choosing', '{"Chance": ">= 20 and < 40", "$right": "missing"}', '{"set": "right = 1", "motion": "walk_right", "wait": "1 | 2 | 3"}', 'Choosing', NULL),
    ('uxa90', 'show', 6, '', 'Choosing', '{"Chance": ">= 40 and < 60", "$turn_left": "missing"}', '{"set": "turn_left = 1", "motion": "turn_left", "wait": "1 | 2 | 3"}', 'Choosing', NULL),
    ('uxa90', 'show', 7, '', 'Choosing', '{"Chance": ">= 60 and < 80", "$turn_right": "missing"}', '{"set": "turn_right = 1", "motion": "turn_right", "wait": "1 | 2 | 3"}', 'Choosing', NULL),
    ('uxa90', 'show', 8, '', 'Choosing', '{"Chance": ">= 80", "$kick": "missing"}', '{"set": "kick = 1", "motion": "kick_right", "wait": "1 | 2 | 3"}', 'Choosing', NULL),
    ('uxa90', 'show', 9, '', 'Choosing', '{"$left": "missing"}', '{"set": "left = 1", "motion": "walk_left", "wait": "1 | 2 | 3"}', 'Choosing', NULL),
    ('uxa90', 'show', 10, '', 'Choosing', '{"$right": "missing"}', '{"set": "right = 1", "motion": "walk_right", "wait": "1 | 2 | 3"}', 'Choosing', NULL),
    ('uxa90', 'show', 11, '', 'Choosing', '{"$turn_left": "missing"}', '{"set": "turn_left = 1", "motion": "turn_left", "wait": "1 | 2 | 3"}', 'Choosing', NULL),
    ('uxa90', 'show', 12, '', 'Choosing', '{"$turn_right": "missing"}', '{"set": "turn_right = 1", "motion": "turn_right", "wait": "1 | 2 | 3"}', 'Choosing', NULL),
    ('uxa90', 'show', 13, '', 'Choosing', '{"$kick": "missing"}', '{"set": "kick = 1", "motion": "kick_right", "wait": "1 | 2 | 3"}', 'Choosing', NULL),
    ('uxa90', 'show', 14, '', 'Choosing', '{}', '{"motion": "dance_gangnamstyle", "wait": "2", "speech": "And now I dance"}', 'Danced', NULL),
    ('uxa90', 'show', 15, '', 'Danced', '{}', '{"motion": "reset", "speech": "Thank you"}', 'Over', NULL),
    ('uxa90', 'show', 16, 'end', 'Over', '{}', '{}', '', NULL),
    ('uxa90', 'show', 17, 'fail', 'Broken off', '{}', '{}', '', NULL);
