-- The robot as rows: schema and shipped rows of an lbr database, to be read from top to bottom.
--
-- `lbr` builds robot.db from this file at its first run; `sqlite3 robot.db < robot.db.sql && chmod 600 robot.db` builds
-- the same. Afterwards robot.db is the robot: edit it with any SQLite client, also while the robot runs. A committed
-- edit takes effect within two seconds, or is refused as a whole and reported; nothing is read from here any more.
-- `lbr db check` says what is wrong with the rows, `lbr db diff` what differs from this file.
--
-- Switch foreign keys on in your client (`PRAGMA foreign_keys = ON`) and let it wait for others
-- (`PRAGMA busy_timeout = 2000`). Times are ISO 8601 in UTC unless their name ends in _ns. Names are small letters,
-- digits and underscores.

PRAGMA application_id = 0x4C425231;  -- "LBR1": how lbr and file(1) know a robot database
PRAGMA journal_mode = WAL;           -- readers and a writer do not wait for each other
PRAGMA foreign_keys = ON;

BEGIN;

-- The revision of the schema, kept by the migrations in lbr/database/migrations. Not to be edited.
CREATE TABLE alembic_version (
    version_num TEXT NOT NULL PRIMARY KEY  -- a revision's identifier
) STRICT;
INSERT INTO alembic_version (version_num) VALUES ('0007');

-- The robots that this file describes; `lbr` runs one of them. Its name is the first part of every key on the bus.
CREATE TABLE robot (
    name          TEXT    NOT NULL PRIMARY KEY  -- by which a launch profile and every other table know it
        CHECK (name GLOB '[a-z]*' AND name NOT GLOB '*[^a-z0-9_]*' AND length(name) <= 40),
    model         TEXT    NOT NULL DEFAULT '',  -- what it is built as
    description   TEXT    NOT NULL DEFAULT '',  -- for people
    owner         TEXT    NOT NULL DEFAULT '',  -- for people
    last_start    TEXT,                         -- when it last started; written by lbr
    last_shutdown TEXT,                         -- when it last shut down in order; written by lbr
    estop_engaged INTEGER NOT NULL DEFAULT 0    -- 1: the emergency stop is latched, and stays so over restarts
        CHECK (estop_engaged IN (0, 1)),
    estop_reason  TEXT    NOT NULL DEFAULT ''   -- why it was latched
) STRICT;

-- What runs: one process for each enabled row.
CREATE TABLE capability (
    robot    TEXT    NOT NULL REFERENCES robot (name) ON UPDATE CASCADE ON DELETE CASCADE,  -- whose it is
    name     TEXT    NOT NULL  -- the second part of its keys on the bus; `executive` is lbr itself
        CHECK (name GLOB '[a-z]*' AND name NOT GLOB '*[^a-z0-9_]*' AND length(name) <= 40 AND name <> 'executive'),
    kind     TEXT    NOT NULL  -- which capability class: a registered one, or a file in $LBR_HOME/capabilities
        CHECK (kind GLOB '[a-z]*' AND kind NOT GLOB '*[^a-z0-9_]*' AND length(kind) <= 40),
    enabled  INTEGER NOT NULL DEFAULT 1             -- 0: not started
        CHECK (enabled IN (0, 1)),
    settings TEXT    NOT NULL DEFAULT '{}'          -- JSON object: what the kind may set; unknown keys are refused
        CHECK (json_valid(settings) AND json_type(settings) = 'object'),
    restart  TEXT    NOT NULL DEFAULT 'on-failure'  -- when it ends: leave it, start it again after a failure, always
        CHECK (restart IN ('never', 'on-failure', 'always')),
    needs    TEXT    NOT NULL DEFAULT '[]'          -- JSON list of capability names that start before it
        CHECK (json_valid(needs) AND json_type(needs) = 'array'),
    help     TEXT    NOT NULL DEFAULT '',           -- for people
    PRIMARY KEY (robot, name)
) STRICT;

-- The wiring: which output feeds which input.
CREATE TABLE channel (
    robot   TEXT    NOT NULL REFERENCES robot (name) ON UPDATE CASCADE ON DELETE CASCADE,  -- whose it is
    source  TEXT    NOT NULL  -- capability.output
        CHECK (source GLOB '[a-z]*.[a-z]*' AND source NOT GLOB '*[^a-z0-9_.]*' AND source NOT GLOB '*.*.*'),
    target  TEXT    NOT NULL  -- capability.input
        CHECK (target GLOB '[a-z]*.[a-z]*' AND target NOT GLOB '*[^a-z0-9_.]*' AND target NOT GLOB '*.*.*'),
    rate_hz REAL              -- at most so many messages a second; NULL: every one
        CHECK (rate_hz > 0 AND rate_hz <= 1000000),
    history INTEGER NOT NULL DEFAULT 1  -- how many of the newest messages wait for the reader
        CHECK (history BETWEEN 1 AND 64),
    enabled INTEGER NOT NULL DEFAULT 1  -- 0: not wired
        CHECK (enabled IN (0, 1)),
    PRIMARY KEY (robot, source, target)
) STRICT;

-- What is plugged in. A capability's setting `device` names a row of this table.
CREATE TABLE device (
    robot    TEXT NOT NULL REFERENCES robot (name) ON UPDATE CASCADE ON DELETE CASCADE,  -- whose it is
    name     TEXT NOT NULL  -- by which settings and calibrations know it
        CHECK (name GLOB '[a-z]*' AND name NOT GLOB '*[^a-z0-9_]*' AND length(name) <= 40),
    type     TEXT NOT NULL  -- what it is; a kind says which type it drives
        CHECK (type GLOB '[a-z]*' AND type NOT GLOB '*[^a-z0-9_]*' AND length(type) <= 40),
    address  TEXT NOT NULL  -- a path, usb:VID:PID[:SERIAL], by-id:GLOB, i2c:BUS:ADDRESS, unix:PATH
        CHECK (length(address) BETWEEN 1 AND 500),
    settings TEXT NOT NULL DEFAULT '{}'  -- JSON object: what its type may set, such as the faults of its emulated twin
        CHECK (json_valid(settings) AND json_type(settings) = 'object'),
    PRIMARY KEY (robot, name)
) STRICT;

-- The console's vocabulary. A word may have several patterns. `/r/{power}/{angle_deg}` binds the parts of a line to
-- fields of the target command's message, `{text...}` takes the rest of the line with its slashes, and a pattern
-- without a slash is an alias, to be typed as it stands.
CREATE TABLE verb (
    robot   TEXT NOT NULL REFERENCES robot (name) ON UPDATE CASCADE ON DELETE CASCADE,  -- whose it is
    word    TEXT NOT NULL  -- the first part of the pattern; capital letters count
        CHECK (word GLOB '[A-Za-z]*' AND word NOT GLOB '*[^A-Za-z0-9_]*' AND length(word) <= 40),
    pattern TEXT NOT NULL  -- a line's form, see above
        CHECK (pattern = word OR pattern = '/' || word OR substr(pattern, 1, length(word) + 2) = '/' || word || '/'),
    target  TEXT NOT NULL  -- capability.command, or executive.NAME for what lbr does by itself
        CHECK (target GLOB '[a-z]*.[a-z]*' AND target NOT GLOB '*[^a-z0-9_.]*' AND target NOT GLOB '*.*.*'),
    payload TEXT           -- JSON object: fields of the message that the pattern does not bind; NULL: none
        CHECK (payload IS NULL OR (json_valid(payload) AND json_type(payload) = 'object')),
    role    TEXT NOT NULL DEFAULT 'operate'  -- the least role that may say it
        CHECK (role IN ('view', 'operate', 'admin')),
    help    TEXT NOT NULL DEFAULT '',        -- one line for people, with units and bounds
    PRIMARY KEY (robot, word, pattern)
) STRICT;

-- Programs started at the console by name, without a shell. What follows the name is added to the arguments, as far as
-- the row allows it: `arguments` has an entry for each argument, in their order, and the last ones may be left out. An
-- entry is a list of the words that are taken, such as ["left", "right"], or a regular expression that all of the
-- argument must fit, such as "[0-9]{1,3}". Nothing that begins with '-' is taken unless it stands in a list.
CREATE TABLE external_command (
    robot     TEXT    NOT NULL REFERENCES robot (name) ON UPDATE CASCADE ON DELETE CASCADE,  -- whose it is
    name      TEXT    NOT NULL  -- what to type
        CHECK (name GLOB '[a-z]*' AND name NOT GLOB '*[^a-z0-9_]*' AND length(name) <= 40),
    argv      TEXT    NOT NULL            -- JSON list of strings: the program's path, then its arguments
        CHECK (json_valid(argv) AND json_type(argv) = 'array' AND json_array_length(argv) >= 1),
    blocking  INTEGER NOT NULL DEFAULT 0  -- 1: the console waits for its end; 0: it runs until it ends or `stop NAME`
        CHECK (blocking IN (0, 1)),
    enabled   INTEGER NOT NULL DEFAULT 1  -- 0: not offered
        CHECK (enabled IN (0, 1)),
    help      TEXT    NOT NULL DEFAULT '',  -- one line for people
    arguments TEXT                        -- JSON list of what may follow the name, see above; NULL: nothing
        CHECK (arguments IS NULL OR (json_valid(arguments) AND json_type(arguments) = 'array')),
    role      TEXT    NOT NULL DEFAULT 'operate'  -- the least role that may start and end it
        CHECK (role IN ('view', 'operate', 'admin')),
    PRIMARY KEY (robot, name)
) STRICT;

-- What the robots say, by name and language.
CREATE TABLE phrase (
    name     TEXT NOT NULL  -- by which programs know it
        CHECK (name GLOB '[a-z]*' AND name NOT GLOB '*[^a-z0-9_]*' AND length(name) <= 40),
    language TEXT NOT NULL  -- a language tag in small letters: en, de, pt-br
        CHECK (language GLOB '[a-z][a-z]*' AND language NOT GLOB '*[^a-z0-9-]*' AND length(language) <= 20),
    text     TEXT NOT NULL  -- what is said
        CHECK (length(text) BETWEEN 1 AND 1000),
    PRIMARY KEY (name, language)
) STRICT;

-- What the robots dance: one move after the other, to the beats of a song.
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

-- Numbers measured on one device, written back by calibration runs; its driver gets them at its start.
CREATE TABLE calibration (
    robot       TEXT NOT NULL,  -- whose it is
    device      TEXT NOT NULL,  -- which device was measured
    name        TEXT NOT NULL  -- what was measured, with its unit as a suffix
        CHECK (name GLOB '[a-z]*' AND name NOT GLOB '*[^a-z0-9_]*' AND length(name) <= 40),
    value       REAL NOT NULL  -- the number
        CHECK (value BETWEEN -1e300 AND 1e300),
    measured_at TEXT NOT NULL DEFAULT (strftime('%Y-%m-%dT%H:%M:%fZ', 'now')),  -- when
    PRIMARY KEY (robot, device, name),
    FOREIGN KEY (robot, device) REFERENCES device (robot, name) ON UPDATE CASCADE ON DELETE CASCADE
) STRICT;

-- Humanoids: the joints.
CREATE TABLE joint (
    robot     TEXT    NOT NULL REFERENCES robot (name) ON UPDATE CASCADE ON DELETE CASCADE,  -- whose it is
    name      TEXT    NOT NULL  -- by which motions know it
        CHECK (name GLOB '[a-z]*' AND name NOT GLOB '*[^a-z0-9_]*' AND length(name) <= 40),
    device_id INTEGER NOT NULL  -- the servo's number on its bus
        CHECK (device_id BETWEEN 0 AND 253),
    side      TEXT    NOT NULL DEFAULT 'centre'  -- which half of the body it belongs to
        CHECK (side IN ('left', 'right', 'centre')),
    sign      INTEGER NOT NULL DEFAULT 1  -- 1 or -1: whether the servo turns the way the joint counts
        CHECK (sign IN (-1, 1)),
    zero_rad  REAL    NOT NULL DEFAULT 0  -- the servo's angle where the joint is at 0
        CHECK (zero_rad BETWEEN -10 AND 10),
    lower_rad REAL    NOT NULL            -- limits of the joint's angle
        CHECK (lower_rad BETWEEN -10 AND 10),
    upper_rad REAL    NOT NULL  -- see lower_rad
        CHECK (upper_rad BETWEEN -10 AND 10),
    speed_rps REAL    NOT NULL            -- the fastest it may move, radians a second
        CHECK (speed_rps > 0 AND speed_rps <= 100),
    PRIMARY KEY (robot, name),
    CHECK (lower_rad < upper_rad)
) STRICT;

-- Humanoids: the named motions.
CREATE TABLE motion (
    robot    TEXT NOT NULL REFERENCES robot (name) ON UPDATE CASCADE ON DELETE CASCADE,  -- whose it is
    name     TEXT NOT NULL  -- by which it is played
        CHECK (name GLOB '[a-z]*' AND name NOT GLOB '*[^a-z0-9_]*' AND length(name) <= 40),
    help     TEXT NOT NULL DEFAULT '',  -- one line for people
    lead_in  TEXT NOT NULL DEFAULT ''  -- the motion that is played once before it; empty: none
        CHECK (lead_in = '' OR (lead_in GLOB '[a-z]*' AND lead_in NOT GLOB '*[^a-z0-9_]*')),
    lead_out TEXT NOT NULL DEFAULT ''  -- the motion that is played once after it, unless it was stopped; empty: none
        CHECK (lead_out = '' OR (lead_out GLOB '[a-z]*' AND lead_out NOT GLOB '*[^a-z0-9_]*')),
    slot     INTEGER                   -- the number under which the robot's own controller keeps and plays it; or NULL
        CHECK (slot BETWEEN 1 AND 255),
    slot_s   REAL                      -- how long the controller takes for it
        CHECK (CASE WHEN slot IS NULL THEN slot_s IS NULL ELSE coalesce(slot_s > 0 AND slot_s <= 600, 0) END),
    limp     INTEGER NOT NULL DEFAULT 0  -- 1: the controller lets the joints go at its end
        CHECK (limp IN (0, 1)),
    builtin  INTEGER NOT NULL DEFAULT 0  -- 1: is changed here only, not from the network
        CHECK (builtin IN (0, 1)),
    PRIMARY KEY (robot, name)
) STRICT;

-- Humanoids: the key frames of a motion, in their order. Those of a motion in a slot say where it leads.
CREATE TABLE motion_step (
    robot      TEXT    NOT NULL,  -- whose it is
    motion     TEXT    NOT NULL,  -- which motion it belongs to
    step       INTEGER NOT NULL  -- the order, from 1
        CHECK (step >= 1),
    duration_s REAL    NOT NULL  -- the time to get there from the step before
        CHECK (duration_s > 0 AND duration_s <= 60),
    positions  TEXT    NOT NULL  -- JSON object: joint name to angle in radians; joints left out stay
        CHECK (json_valid(positions) AND json_type(positions) = 'object'),
    PRIMARY KEY (robot, motion, step),
    FOREIGN KEY (robot, motion) REFERENCES motion (robot, name) ON UPDATE CASCADE ON DELETE CASCADE
) STRICT;

-- The servos as a face to the outside numbers, names and limits them, in the servos' own counts; in layers, of which a
-- face uses one. Whatever a layer allows, the limits of the joints hold.
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
) STRICT;

-- The motions as a face to the outside numbers and names them; several numbers may mean one motion.
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
) STRICT;

-- Who may do what. The token itself is shown once and never stored.
CREATE TABLE user_token (
    name       TEXT NOT NULL PRIMARY KEY  -- whose it is
        CHECK (length(name) BETWEEN 1 AND 40),
    role       TEXT NOT NULL              -- look, move, change, or run a share of the robot
        CHECK (role IN ('view', 'operate', 'admin', 'host')),
    hash       TEXT NOT NULL              -- of the token
        CHECK (length(hash) >= 32),
    created_at TEXT NOT NULL DEFAULT (strftime('%Y-%m-%dT%H:%M:%fZ', 'now')),  -- when
    revoked_at TEXT,                      -- NULL: valid
    expires_at TEXT,                      -- NULL: never
    good_for   TEXT NOT NULL DEFAULT 'both'  -- where it lets in: the bus, the web server, or both
        CHECK (good_for IN ('bus', 'web', 'both'))
) STRICT;

-- Every change of the rows above that make the robot, kept by the triggers at the end of this file.
CREATE TABLE revision (
    id         INTEGER NOT NULL PRIMARY KEY AUTOINCREMENT,  -- counts up, and is never used again
    table_name TEXT NOT NULL,  -- which table
    row_key    TEXT NOT NULL  -- JSON list: the row's primary key (after an update, the new one)
        CHECK (json_valid(row_key)),
    operation  TEXT NOT NULL  -- what was done to the row
        CHECK (operation IN ('insert', 'update', 'delete')),
    old_row    TEXT           -- JSON object: the row before; NULL for an insert
        CHECK (old_row IS NULL OR json_valid(old_row)),
    new_row    TEXT           -- JSON object: the row after; NULL for a delete
        CHECK (new_row IS NULL OR json_valid(new_row)),
    changed_at TEXT NOT NULL DEFAULT (strftime('%Y-%m-%dT%H:%M:%fZ', 'now'))  -- when
) STRICT;

-- What happened; written by lbr, the oldest go when there are very many.
CREATE TABLE event (
    id      INTEGER NOT NULL PRIMARY KEY AUTOINCREMENT,  -- counts up, and is never used again
    wall_ns INTEGER NOT NULL  -- nanoseconds since 1970 by the wall clock
        CHECK (wall_ns >= 0),
    kind    TEXT    NOT NULL,  -- started, stopped, crashed, refused, row_changed ...
    subject TEXT    NOT NULL DEFAULT '',  -- the capability, or whom it is about
    level   TEXT    NOT NULL DEFAULT 'info'  -- how much it matters
        CHECK (level IN ('info', 'warning', 'error')),
    text    TEXT    NOT NULL DEFAULT '',  -- one sentence
    data    TEXT    NOT NULL DEFAULT '{}'  -- JSON object: figures that belong to it
        CHECK (json_valid(data) AND json_type(data) = 'object')
) STRICT;

-- The audit trail: who did what to the robot. Each row's hash covers the hash before it, so that `lbr db check` finds a
-- row that was changed or taken out; the oldest go when there are very many. Written by lbr, and never changed.
CREATE TABLE audit (
    id       INTEGER NOT NULL PRIMARY KEY AUTOINCREMENT,  -- counts up without a gap
    wall_ns  INTEGER NOT NULL  -- nanoseconds since 1970 by the wall clock
        CHECK (wall_ns >= 0),
    kind     TEXT    NOT NULL,  -- run, shutdown, holder, stopped, estop, login, rows_changed, python ...
    subject  TEXT    NOT NULL,  -- the capability, or whom it is about
    source   TEXT    NOT NULL,  -- who said so, as robot/capability
    text     TEXT    NOT NULL,  -- one sentence
    previous TEXT    NOT NULL,  -- the hash of the row before; empty for the very first
    hash     TEXT    NOT NULL   -- BLAKE2b over all of this row but itself
) STRICT;

-- The row sets that ran, so that rows which change without an edit are noticed. Written by lbr.
CREATE TABLE adopted (
    revision INTEGER NOT NULL PRIMARY KEY,  -- the last change of rows that was in it; 0: none
    hash     TEXT    NOT NULL,              -- BLAKE2b over the rows that make robots
    wall_ns  INTEGER NOT NULL               -- when it was adopted first, nanoseconds since 1970
        CHECK (wall_ns >= 0)
) STRICT;


-- ---------------------------------------------------------------------------------------------------------------------
-- lbr: a telepresence robot on two driven wheels, with a ring of ultrasonic sensors.

INSERT INTO robot (name, model, description)
VALUES ('lbr', 'lbr6', 'Two driven wheels on a Roboteq SDC21xx, ultrasonic ranges ahead, behind and to both sides');

-- The addresses are examples, unverified on hardware: `ls /dev/serial/by-id` shows yours. A simulating launch profile
-- puts emulated devices in their place.
INSERT INTO device (robot, name, type, address, settings) VALUES
    ('lbr', 'motor_controller', 'roboteq', '/dev/serial/by-id/usb-Roboteq_Motor_Controller-if00', '{}'),
    ('lbr', 'range_board', 'ultrasonic_ring', '/dev/serial/by-id/usb-Arduino-if00', '{}'),
    ('lbr', 'front_camera', 'camera', '/dev/video0', '{"mount": "front"}'),
    ('lbr', 'rear_camera', 'camera', '/dev/video2', '{"mount": "rear"}'),
    ('lbr', 'imu', 'mpu9150', 'i2c:1:0x68', '{}'),
    ('lbr', 'speaker', 'speaker', 'alsa:default', '{}'),
    ('lbr', 'dock_receiver', 'infrared', '/dev/lirc0', '{}');

INSERT INTO capability (robot, name, kind, settings, needs, help) VALUES
    ('lbr', 'motors', 'roboteq',
     '{"device": "motor_controller",
       "left": {"channel": 1, "direction": -1},
       "right": {"channel": 2, "direction": 1}}', '[]',
     'The motor controller: left wheel on channel 1, mounted mirrored, right wheel on channel 2'),
    ('lbr', 'ranges', 'ultrasonic_ring', '{"device": "range_board"}', '[]',
     'The ring of ultrasonic sensors: distances ahead, behind, left and right'),
    ('lbr', 'imu', 'mpu9150', '{"device": "imu"}', '[]',
     'The inertial unit: acceleration, rate of turn and magnetic field, along its own axes'),
    ('lbr', 'drive', 'drive', '{}', '["motors", "ranges"]',
     'The base: who drives, how fast and how near to obstacles'),
    ('lbr', 'attitude', 'attitude', '{"device": "imu"}', '["imu"]',
     'The attitude: how the body lies, where it looks, how far it turned; and the compass''s calibration'),
    ('lbr', 'odometry', 'odometry', '{}', '["motors"]',
     'The odometry: how far the base went by its wheels, and whether they stall or slip'),
    ('lbr', 'battery', 'battery', '{}', '["motors"]',
     'The battery: its charge, whether it is being charged, and warnings when it is low'),
    ('lbr', 'speech', 'speech', '{"device": "speaker"}', '[]',
     'The voice: says texts and phrases, and plays songs'),
    ('lbr', 'dance', 'dance', '{}', '["drive", "speech"]',
     'Dances to a song: drives at its beats, within all that the drive allows'),
    ('lbr', 'dock', 'infrared', '{"device": "dock_receiver"}', '[]',
     'The receiver of the charging dock''s infrared beams: which of them it sees'),
    ('lbr', 'camera_front', 'camera', '{"device": "front_camera", "on": true}', '[]',
     'The camera that looks ahead'),
    ('lbr', 'camera_rear', 'camera',
     '{"device": "rear_camera",
       "controls": {"power_line_frequency": 2, "brightness": 17, "auto_exposure": 1, "exposure_time_absolute": 681}}',
     '[]', 'The camera that looks back'),
    ('lbr', 'cameras', 'cameras', '{}', '["camera_front", "camera_rear"]',
     'Which camera is on: one at a time'),
    ('lbr', 'telemetry', 'telemetry', '{}', '[]',
     'All that the robot knows of itself, in one message'),
    ('lbr', 'world', 'world', '{}', '[]',
     'The simulated surroundings; runs only under a simulating launch profile');

-- Off: nothing on the robot can be reached from other machines. `UPDATE capability SET enabled = 1 WHERE name = 'lan'`
-- lets in whoever has a token (`lbr token add NAME`); the same with 'web' serves the robot over HTTP, to this machine.
INSERT INTO capability (robot, name, kind, enabled, settings, help) VALUES
    ('lbr', 'lan', 'lan', 0, '{"listen": ["tls/0.0.0.0:7447"]}',
     'The door to other machines: whoever has a token comes in'),
    ('lbr', 'web', 'web', 0, '{"faces": ["cameras"]}',
     'The robot over HTTP: its state, stop, cameras; on this machine only, unless the settings say otherwise');

INSERT INTO channel (robot, source, target, history) VALUES
    ('lbr', 'drive.setpoint', 'motors.setpoint', 1),
    ('lbr', 'motors.state', 'drive.motors', 1),
    ('lbr', 'ranges.readings', 'drive.ranges', 1),
    ('lbr', 'imu.sample', 'attitude.samples', 32),
    ('lbr', 'imu.sample', 'telemetry.imu', 32),
    ('lbr', 'attitude.motion', 'drive.command', 1),
    ('lbr', 'attitude.halt', 'drive.stop', 1),
    ('lbr', 'attitude.state', 'drive.attitude', 1),
    ('lbr', 'attitude.state', 'odometry.attitude', 1),
    ('lbr', 'motors.state', 'odometry.motors', 1),
    ('lbr', 'odometry.state', 'drive.odometry', 1),
    ('lbr', 'camera_front.state', 'cameras.states', 4),
    ('lbr', 'camera_rear.state', 'cameras.states', 4),
    ('lbr', 'cameras.switch', 'camera_front.switch', 1),
    ('lbr', 'cameras.switch', 'camera_rear.switch', 1),
    ('lbr', 'dance.motion', 'drive.command', 1),
    ('lbr', 'dance.halt', 'drive.stop', 1),
    ('lbr', 'dance.sound', 'speech.play', 1),
    ('lbr', 'dance.hush', 'speech.hush', 1),
    ('lbr', 'speech.state', 'dance.speech', 1),
    ('lbr', 'drive.state', 'web.drive', 1),
    ('lbr', 'ranges.readings', 'web.ranges', 1),
    ('lbr', 'battery.state', 'web.battery', 1),
    ('lbr', 'camera_front.frame', 'web.frames', 2),
    ('lbr', 'camera_rear.frame', 'web.frames', 2),
    ('lbr', 'camera_front.state', 'web.cameras', 4),
    ('lbr', 'camera_rear.state', 'web.cameras', 4),
    ('lbr', 'web.halt', 'drive.stop', 1),
    ('lbr', 'web.estop_reset', 'executive.estop_reset', 1);

-- What needs no more than a few messages a second gets no more.
INSERT INTO channel (robot, source, target, rate_hz) VALUES
    ('lbr', 'motors.state', 'battery.motors', 5),
    ('lbr', 'battery.say', 'speech.say', NULL),
    ('lbr', 'ranges.readings', 'telemetry.ranges', 10),
    ('lbr', 'motors.state', 'telemetry.motors', 10),
    ('lbr', 'attitude.state', 'telemetry.attitude', 10),
    ('lbr', 'odometry.state', 'telemetry.odometry', 10),
    ('lbr', 'cameras.state', 'telemetry.cameras', 10),
    ('lbr', 'battery.state', 'telemetry.battery', 10),
    ('lbr', 'dock.signal', 'telemetry.dock', 10);

INSERT INTO verb (robot, word, pattern, target, payload, role, help) VALUES
    ('lbr', 'r', '/r/{power}/{angle_deg}', 'drive.command', NULL, 'operate',
     'Drive: power 0 to 1 of full, angle in degrees clockwise (0 ahead, 90 right, 180 back, 270 left)'),
    ('lbr', 'r', '/r/{power}/{angle_deg}/{range_cm}/{sensor}/{interval_s}', 'drive.command', NULL, 'operate',
     'Drive until a sensor (forward, back, left, right, bottom) reads the range, 0 to 769 cm, '
     || 'or the time is over, 0 to 3600 s; 0 sets no bound'),
    ('lbr', 'f', 'f', 'drive.command', '{"power": 0.25, "angle_deg": 0}', 'operate',
     'Drive ahead at a quarter of full power'),
    ('lbr', 'b', 'b', 'drive.command', '{"power": 0.25, "angle_deg": 180}', 'operate',
     'Drive back at a quarter of full power'),
    ('lbr', 'go', '/go/{distance_cm}/{power}', 'drive.command', '{"angle_deg": 0}', 'operate',
     'Drive straight ahead by a distance, 1 to 10000 cm, such as /go/150/0.3: slower near its end, then stop'),
    ('lbr', 'back', '/back/{distance_cm}/{power}', 'drive.command', '{"angle_deg": 180}', 'operate',
     'Drive straight back by a distance, 1 to 10000 cm, such as /back/50/0.2'),
    ('lbr', 't', '/t/{angle_deg}', 'drive.turn', NULL, 'operate',
     'Turn on the spot by an angle, -360 to 360 degrees, clockwise positive, such as /t/90 or /t/-45'),
    ('lbr', 'h', '/h/{heading_deg}', 'drive.heading', NULL, 'operate',
     'Turn on the spot to a compass heading, 0 to 360 degrees (0 north, 90 east), the shorter way'),
    ('lbr', 'a', '/a/{angle_deg}', 'attitude.observe', NULL, 'operate',
     'Tell when the robot has turned by an angle from now on, -360 to 360 degrees, clockwise positive; moves nothing'),
    ('lbr', 'm', '/m/{samples}', 'attitude.calibrate', NULL, 'operate',
     'Calibrate the compass while turning on the spot, such as /m/300; s ends it'),
    ('lbr', 'm', '/m/{samples}/{source}', 'attitude.calibrate', NULL, 'operate',
     'The same: - turns, -c turns and only draws what the compass says now, '
     || 'a name means a file of samples in $LBR_HOME/calibration'),
    ('lbr', 's', '/s/{text...}', 'speech.say', NULL, 'operate',
     'Say a text, 5000 characters at most; one that is <name plays a recording'),
    ('lbr', 'say', '/say/{phrase}', 'speech.say', NULL, 'operate', 'Say a phrase by its name, such as /say/hello'),
    ('lbr', 'save', '/save/{save}/{text...}', 'speech.say', NULL, 'operate',
     'Save a text as a recording instead of saying it; /s/<name plays it'),
    ('lbr', 'hush', 'hush', 'speech.hush', NULL, 'operate', 'Say no more: ends speech and song, and drops what waits'),
    ('lbr', 'd', '/d/{song}', 'dance.play', NULL, 'operate',
     'Dance to a song: /d/metronome is always there; yours are NAME.wav and NAME.json in $LBR_HOME/music'),
    ('lbr', 'd', '/d/{song}/{dance}', 'dance.play', NULL, 'operate',
     'Dance to a song by a choreography, such as /d/metronome/to_and_fro'),
    ('lbr', 'camera', '/camera/{name}', 'cameras.select', NULL, 'operate',
     'Switch a camera on and the others off: front, rear, or off for none'),
    ('lbr', 'snapshot', '/snapshot/front', 'camera_front.snapshot', NULL, 'operate',
     'Save what the front camera sees as a picture, named after the time'),
    ('lbr', 'snapshot', '/snapshot/front/{name}', 'camera_front.snapshot', NULL, 'operate',
     'Save what the front camera sees as a picture of that name'),
    ('lbr', 'snapshot', '/snapshot/rear', 'camera_rear.snapshot', NULL, 'operate',
     'Save what the rear camera sees as a picture, named after the time'),
    ('lbr', 'snapshot', '/snapshot/rear/{name}', 'camera_rear.snapshot', NULL, 'operate',
     'Save what the rear camera sees as a picture of that name'),
    ('lbr', 'report', '/report/{name}', 'executive.report', NULL, 'view',
     'Show telemetry, settings, statistics, health, events or wiring'),
    ('lbr', 'restart', '/restart/{name}', 'executive.restart', NULL, 'admin',
     'Stop a capability and start it anew, by its name'),
    ('lbr', 'enable', 'enable', 'motors.enable', '{"enabled": true}', 'operate',
     'Let the motors run again after disable'),
    ('lbr', 'disable', 'disable', 'motors.enable', '{"enabled": false}', 'operate',
     'Hold the motors at zero until enable, whatever is commanded'),
    ('lbr', 'map', 'map', 'world.picture', NULL, 'admin', 'Save a picture of the simulated surroundings from above'),
    ('lbr', 'picture', 'picture', 'world.picture', NULL, 'admin',
     'Save a picture of the simulated surroundings from above'),
    ('lbr', 'fault', '/fault/{device}/{name}', 'world.fault', '{"value": true}', 'admin',
     'Simulation: let an emulated device fail, such as /fault/motor_controller/unplug or /fault/range_board/silent'),
    ('lbr', 'fault', '/fault/{device}/{name}/off', 'world.fault', '{"value": null}', 'admin',
     'Simulation: end a fault of an emulated device'),
    ('lbr', 'fault', '/fault/{device}/{name}/{value}', 'world.fault', NULL, 'admin',
     'Simulation: a fault with a number or names, such as /fault/imu/noise/5 or /fault/range_board/missing/left'),
    ('lbr', 'obstacle', '/obstacle/{x_m}/{y_m}', 'world.place', NULL, 'admin',
     'Simulation: let a box of 0.3 m stand at this place, metres ahead of and left of where the world began'),
    ('lbr', 'obstacle', '/obstacle/off', 'world.remove', NULL, 'admin', 'Simulation: let that box vanish');

INSERT INTO external_command (robot, name, argv, blocking, arguments, role, help) VALUES
    ('lbr', 'clock', '["/bin/date"]', 1, NULL, 'view', 'Show date and time of the robot''s computer'),
    ('lbr', 'navcam', '["python", "-m", "lbr.apps.navcam"]', 0, NULL, 'operate',
     'Serve the cameras to browsers; its address is in run/lbr-navcam.url. To whom, and where, its row says'),
    ('lbr', 'docksignal', '["python", "-m", "lbr.apps.docksignal"]', 1,
     '[["left", "right", "power"], ["left", "right", "power"], ["left", "right", "power"]]', 'operate',
     'Tell that somebody else has seen a beam of the dock: docksignal left, right or power'),
    ('lbr', 'autodock', '["python", "-m", "lbr.apps.autodock"]', 0, NULL, 'operate',
     'Find the charging dock and back onto it; stop autodock ends it');

INSERT INTO choreography (robot, dance, step, power, angle_deg) VALUES
    ('lbr', 'to_and_fro', 1, 0.3, 0),
    ('lbr', 'to_and_fro', 2, 0.3, 180),
    ('lbr', 'to_and_fro', 3, 0.3, 0),
    ('lbr', 'to_and_fro', 4, 0.3, 180),
    ('lbr', 'to_and_fro', 5, 0.3, 270),
    ('lbr', 'to_and_fro', 6, 0.3, 90),
    ('lbr', 'to_and_fro', 7, 0.3, 90),
    ('lbr', 'to_and_fro', 8, 0.3, 270);

INSERT INTO phrase (name, language, text) VALUES
    ('hello', 'en', 'Good day. All systems are up.'),
    ('goodbye', 'en', 'Good bye. Going to sleep now.'),
    ('ahead_slow', 'en', 'Going ahead, slowly.'),
    ('ahead_half', 'en', 'Going ahead at half power.'),
    ('ahead_full', 'en', 'Going ahead at three quarters of full power.'),
    ('flank_in_3', 'en', 'Full power ahead in three seconds. Please make way.'),
    ('reverse', 'en', 'Backing up.'),
    ('left_turn', 'en', 'Turning to the left.'),
    ('right_turn', 'en', 'Turning to the right.'),
    ('stop_motors', 'en', 'Stopping.'),
    ('drive_command', 'en', 'Drive command'),
    ('amp', 'en', 'ampere'),
    ('amps', 'en', 'amperes'),
    ('volt', 'en', 'volt'),
    ('volts', 'en', 'volts'),
    ('main_battery', 'en', 'The main battery is at'),
    ('internal_voltage', 'en', 'The controller''s own supply is at'),
    ('motor_1_current', 'en', 'The left motor draws'),
    ('motor_2_current', 'en', 'The right motor draws'),
    ('battery_low', 'en', 'My battery is low. I need my dock.'),
    ('battery_critical', 'en', 'My battery is almost empty.'),
    ('charging', 'en', 'I am being charged.'),
    ('docking', 'en', 'I am going to my dock.'),
    ('docked', 'en', 'I am on my dock.'),
    ('dock_failed', 'en', 'I could not reach my dock. Please help me.');


-- ---------------------------------------------------------------------------------------------------------------------
-- Bioloid: a humanoid of eighteen AX-12A servos, with a PhidgetSpatial under its front cover and a UPS PIco.

INSERT INTO robot (name, model, description)
VALUES ('bioloid', 'Bioloid Humanoid Type A', 'A humanoid of eighteen Dynamixel servos on a Raspberry Pi');

INSERT INTO device (robot, name, type, address, settings) VALUES
    ('bioloid', 'servo_bus', 'dynamixel', 'by-id:usb-*-if00', '{}'),
    ('bioloid', 'imu', 'phidget_spatial', 'usb:', '{}'),
    ('bioloid', 'ups', 'pico', 'i2c:1:0x69', '{}');

INSERT INTO capability (robot, name, kind, settings, needs, help) VALUES
    ('bioloid', 'servos', 'dynamixel', '{"device": "servo_bus"}', '[]',
     'The servo bus: eighteen AX-12A behind a USB2AX'),
    ('bioloid', 'joints', 'joints', '{}', '["servos"]',
     'The joints: who moves them, how far and how fast'),
    ('bioloid', 'motions', 'motions', '{}', '["joints"]',
     'The motions: plays what the rows know, and writes down poses made by hand'),
    ('bioloid', 'imu', 'phidget_spatial', '{"device": "imu"}', '[]',
     'The inertial unit: acceleration, rate of turn and magnetic field, along its own axes'),
    ('bioloid', 'attitude', 'attitude', '{"device": "imu"}', '["imu"]',
     'The attitude: how the trunk lies and where it looks'),
    ('bioloid', 'ups', 'pico', '{"device": "ups"}', '[]',
     'The uninterruptible supply: where the power comes from, and the relay of the motors'' power'),
    -- 3.5 and 3.3 V for each of three lithium-polymer cells; the servos want 9 V at least. Off until somebody says `arm`.
    ('bioloid', 'power', 'power', '{"device": "ups", "warn_v": 10.5, "shutdown_v": 9.9, "park_motion": "sit"}', '["ups"]',
     'The power: shuts the computer down before the voltage is too low'),
    ('bioloid', 'world', 'humanoid_world', '{"model": "bioloid"}', '[]',
     'The simulated body and floor; runs only under a simulating launch profile');

-- Off: nothing on the robot can be reached from other machines, as for lbr.
INSERT INTO capability (robot, name, kind, enabled, settings, help) VALUES
    ('bioloid', 'lan', 'lan', 0, '{"listen": ["tls/0.0.0.0:7447"]}',
     'The door to other machines: whoever has a token comes in'),
    ('bioloid', 'web', 'web', 0, '{}',
     'The robot over HTTP: its state, stop and emergency stop; on this machine only, unless the settings say otherwise');

INSERT INTO channel (robot, source, target, history) VALUES
    ('bioloid', 'joints.setpoint', 'servos.setpoint', 1),
    ('bioloid', 'servos.state', 'joints.servos', 1),
    ('bioloid', 'joints.servos_recover', 'servos.recover', 1),
    ('bioloid', 'joints.state', 'motions.joints', 1),
    ('bioloid', 'joints.result', 'motions.ended', 4),
    ('bioloid', 'motions.move', 'joints.command', 1),
    ('bioloid', 'motions.halt', 'joints.stop', 1),
    ('bioloid', 'imu.sample', 'attitude.samples', 32),
    ('bioloid', 'ups.state', 'power.ups', 1),
    ('bioloid', 'power.park', 'motions.play', 1),
    ('bioloid', 'power.halt', 'motions.stop', 1),
    ('bioloid', 'motions.result', 'power.parked', 4),
    ('bioloid', 'power.let_go', 'joints.torque', 1),
    ('bioloid', 'joints.state', 'web.joints', 1),
    ('bioloid', 'motions.state', 'web.motions', 1),
    ('bioloid', 'web.halt', 'joints.stop', 1),
    ('bioloid', 'web.stop_motion', 'motions.stop', 1),
    ('bioloid', 'web.estop_reset', 'executive.estop_reset', 1);

-- Ids as on the robot's drawing. Signs and zeros follow published descriptions of the Type A; limits are what the
-- motions below use and 15 steps more. Confirm all of them on your robot, by hand and without torque.
-- Mirrored joints count alike: the same angles left and right are a symmetrical pose. At zero it stands upright,
-- arms down.
INSERT INTO joint (robot, name, device_id, side, sign, zero_rad, lower_rad, upper_rad, speed_rps) VALUES
    ('bioloid', 'right_shoulder_pitch', 1, 'right', 1, -1.5708, -0.277, 2.554, 3.0),
    ('bioloid', 'left_shoulder_pitch', 2, 'left', -1, 1.5708, -0.277, 2.554, 3.0),
    ('bioloid', 'right_shoulder_roll', 3, 'right', 1, -1.5708, -0.036, 1.248, 3.0),
    ('bioloid', 'left_shoulder_roll', 4, 'left', -1, 1.5708, -0.036, 1.248, 3.0),
    ('bioloid', 'right_elbow', 5, 'right', 1, 0.0000, -1.930, 0.077, 3.0),
    ('bioloid', 'left_elbow', 6, 'left', -1, 0.0000, -1.930, 0.077, 3.0),
    ('bioloid', 'right_hip_yaw', 7, 'right', 1, -0.7854, -0.095, 0.074, 3.0),
    ('bioloid', 'left_hip_yaw', 8, 'left', -1, 0.7854, -0.095, 0.074, 3.0),
    ('bioloid', 'right_hip_roll', 9, 'right', -1, 0.0000, -0.159, 0.328, 3.0),
    ('bioloid', 'left_hip_roll', 10, 'left', 1, 0.0000, -0.159, 0.328, 3.0),
    ('bioloid', 'right_hip_pitch', 11, 'right', -1, 0.0000, -0.496, 1.300, 3.0),
    ('bioloid', 'left_hip_pitch', 12, 'left', 1, 0.0000, -0.496, 1.300, 3.0),
    ('bioloid', 'right_knee', 13, 'right', 1, 0.0000, -2.339, 0.118, 3.0),
    ('bioloid', 'left_knee', 14, 'left', -1, 0.0000, -2.339, 0.118, 3.0),
    ('bioloid', 'right_ankle_pitch', 15, 'right', 1, 0.0000, -0.118, 1.346, 3.0),
    ('bioloid', 'left_ankle_pitch', 16, 'left', -1, 0.0000, -0.118, 1.346, 3.0),
    ('bioloid', 'right_ankle_roll', 17, 'right', 1, 0.0000, -0.256, 0.189, 3.0),
    ('bioloid', 'left_ankle_roll', 18, 'left', -1, 0.0000, -0.256, 0.189, 3.0);

-- Ours, found by experiment with the simulated body, which stands and walks by them. Nobody has tried
-- them on a robot yet: hang yours up first; its weight and its feet are others. Walking is a rhythm: slower than at
-- speed 0.7 it stumbles. It leaves out the arms, which stay where its lead-in has put them.
INSERT INTO motion (robot, name, help, lead_in, lead_out) VALUES
    ('bioloid', 'initial', 'Stand upright, arms hanging a little away from the body', '', ''),
    ('bioloid', 'ready', 'Stand with knees bent and hands ahead, ready for anything', '', ''),
    ('bioloid', 'wave', 'Wave with the right hand; mirrored, with the left', '', ''),
    ('bioloid', 'wave_both', 'Wave with both hands', '', ''),
    ('bioloid', 'sit', 'Go down on bent knees and stay there', '', ''),
    ('bioloid', 'stand_up', 'Stand up from sitting', '', ''),
    ('bioloid', 'walk_ready', 'Stand as walking begins and ends', '', ''),
    ('bioloid', 'walk', 'Walk on the spot: once with each foot', 'walk_ready', 'walk_ready'),
    ('bioloid', 'walk_ahead', 'Walk ahead: a step with each foot, 4 cm', 'walk_ready', 'walk_ready'),
    ('bioloid', 'walk_back', 'Walk back: a step with each foot, 5 cm', 'walk_ready', 'walk_ready'),
    ('bioloid', 'turn_left', 'Turn left on the spot: a step with each foot, 17 degrees; mirrored, to the right',
     'walk_ready', 'walk_ready');

INSERT INTO motion_step (robot, motion, step, duration_s, positions) VALUES
    ('bioloid', 'initial', 1, 1.500,
     '{"right_shoulder_pitch": 0.025, "left_shoulder_pitch": 0.025, "right_shoulder_roll": 0.445,
      "left_shoulder_roll": 0.445, "right_elbow": -0.143, "left_elbow": -0.143, "right_hip_yaw": -0.018,
      "left_hip_yaw": -0.018, "right_hip_roll": 0.082, "left_hip_roll": 0.082, "right_hip_pitch": 0,
      "left_hip_pitch": 0, "right_knee": 0.041, "left_knee": 0.041, "right_ankle_pitch": -0.041,
      "left_ankle_pitch": -0.041, "right_ankle_roll": -0.061, "left_ankle_roll": -0.061}'),
    ('bioloid', 'ready', 1, 1.200,
     '{"right_shoulder_pitch": 0.3, "left_shoulder_pitch": 0.3, "right_shoulder_roll": 0.35,
      "left_shoulder_roll": 0.35, "right_elbow": -0.6, "left_elbow": -0.6, "right_hip_yaw": 0, "left_hip_yaw": 0,
      "right_hip_roll": 0, "left_hip_roll": 0, "right_hip_pitch": 0.704, "left_hip_pitch": 0.704,
      "right_knee": -1.287, "left_knee": -1.287, "right_ankle_pitch": 0.644, "left_ankle_pitch": 0.644,
      "right_ankle_roll": 0, "left_ankle_roll": 0}'),
    ('bioloid', 'wave', 1, 1.300,
     '{"right_shoulder_pitch": 2.4, "right_shoulder_roll": 0.5, "right_elbow": -0.2}'),
    ('bioloid', 'wave', 2, 0.450,
     '{"right_shoulder_roll": 0.35, "right_elbow": -1}'),
    ('bioloid', 'wave', 3, 0.450,
     '{"right_shoulder_roll": 0.6, "right_elbow": -0.1}'),
    ('bioloid', 'wave', 4, 0.450,
     '{"right_shoulder_roll": 0.35, "right_elbow": -1}'),
    ('bioloid', 'wave', 5, 0.450,
     '{"right_shoulder_roll": 0.6, "right_elbow": -0.1}'),
    ('bioloid', 'wave', 6, 0.450,
     '{"right_shoulder_roll": 0.35, "right_elbow": -1}'),
    ('bioloid', 'wave', 7, 0.450,
     '{"right_shoulder_roll": 0.6, "right_elbow": -0.1}'),
    ('bioloid', 'wave', 8, 1.300,
     '{"right_shoulder_pitch": 0.025, "right_shoulder_roll": 0.445, "right_elbow": -0.143}'),
    ('bioloid', 'wave_both', 1, 1.300,
     '{"right_shoulder_pitch": 2.4, "left_shoulder_pitch": 2.4, "right_shoulder_roll": 0.5, "left_shoulder_roll": 0.5,
      "right_elbow": -0.2, "left_elbow": -0.2}'),
    ('bioloid', 'wave_both', 2, 0.450,
     '{"right_shoulder_roll": 0.35, "left_shoulder_roll": 0.35, "right_elbow": -1, "left_elbow": -1}'),
    ('bioloid', 'wave_both', 3, 0.450,
     '{"right_shoulder_roll": 0.6, "left_shoulder_roll": 0.6, "right_elbow": -0.1, "left_elbow": -0.1}'),
    ('bioloid', 'wave_both', 4, 0.450,
     '{"right_shoulder_roll": 0.35, "left_shoulder_roll": 0.35, "right_elbow": -1, "left_elbow": -1}'),
    ('bioloid', 'wave_both', 5, 0.450,
     '{"right_shoulder_roll": 0.6, "left_shoulder_roll": 0.6, "right_elbow": -0.1, "left_elbow": -0.1}'),
    ('bioloid', 'wave_both', 6, 0.450,
     '{"right_shoulder_roll": 0.35, "left_shoulder_roll": 0.35, "right_elbow": -1, "left_elbow": -1}'),
    ('bioloid', 'wave_both', 7, 0.450,
     '{"right_shoulder_roll": 0.6, "left_shoulder_roll": 0.6, "right_elbow": -0.1, "left_elbow": -0.1}'),
    ('bioloid', 'wave_both', 8, 1.300,
     '{"right_shoulder_pitch": 0.025, "left_shoulder_pitch": 0.025, "right_shoulder_roll": 0.445,
      "left_shoulder_roll": 0.445, "right_elbow": -0.143, "left_elbow": -0.143}'),
    ('bioloid', 'sit', 1, 0.900,
     '{"right_shoulder_pitch": 0.6, "left_shoulder_pitch": 0.6, "right_shoulder_roll": 0.3, "left_shoulder_roll": 0.3,
      "right_elbow": -0.3, "left_elbow": -0.3, "right_hip_yaw": 0, "left_hip_yaw": 0, "right_hip_roll": 0,
      "left_hip_roll": 0, "right_hip_pitch": 0.744, "left_hip_pitch": 0.744, "right_knee": -1.287,
      "left_knee": -1.287, "right_ankle_pitch": 0.644, "left_ankle_pitch": 0.644, "right_ankle_roll": 0,
      "left_ankle_roll": 0}'),
    ('bioloid', 'sit', 2, 0.900,
     '{"right_shoulder_pitch": 0.9, "left_shoulder_pitch": 0.9, "right_hip_yaw": 0, "left_hip_yaw": 0,
      "right_hip_roll": 0, "left_hip_roll": 0, "right_hip_pitch": 1.118, "left_hip_pitch": 1.118,
      "right_knee": -1.937, "left_knee": -1.937, "right_ankle_pitch": 0.968, "left_ankle_pitch": 0.968,
      "right_ankle_roll": 0, "left_ankle_roll": 0}'),
    ('bioloid', 'sit', 3, 0.900,
     '{"right_shoulder_pitch": 1, "left_shoulder_pitch": 1, "right_hip_yaw": 0, "left_hip_yaw": 0,
      "right_hip_roll": 0, "left_hip_roll": 0, "right_hip_pitch": 1.245, "left_hip_pitch": 1.245,
      "right_knee": -2.289, "left_knee": -2.289, "right_ankle_pitch": 1.145, "left_ankle_pitch": 1.145,
      "right_ankle_roll": 0, "left_ankle_roll": 0}'),
    ('bioloid', 'stand_up', 1, 1.000,
     '{"right_shoulder_pitch": 0.9, "left_shoulder_pitch": 0.9, "right_hip_yaw": 0, "left_hip_yaw": 0,
      "right_hip_roll": 0, "left_hip_roll": 0, "right_hip_pitch": 1.118, "left_hip_pitch": 1.118,
      "right_knee": -1.937, "left_knee": -1.937, "right_ankle_pitch": 0.968, "left_ankle_pitch": 0.968,
      "right_ankle_roll": 0, "left_ankle_roll": 0}'),
    ('bioloid', 'stand_up', 2, 0.900,
     '{"right_shoulder_pitch": 0.4, "left_shoulder_pitch": 0.4, "right_hip_yaw": 0, "left_hip_yaw": 0,
      "right_hip_roll": 0, "left_hip_roll": 0, "right_hip_pitch": 0.724, "left_hip_pitch": 0.724,
      "right_knee": -1.287, "left_knee": -1.287, "right_ankle_pitch": 0.644, "left_ankle_pitch": 0.644,
      "right_ankle_roll": 0, "left_ankle_roll": 0}'),
    ('bioloid', 'stand_up', 3, 0.900,
     '{"right_shoulder_pitch": 0.025, "left_shoulder_pitch": 0.025, "right_shoulder_roll": 0.445,
      "left_shoulder_roll": 0.445, "right_elbow": -0.143, "left_elbow": -0.143, "right_hip_yaw": -0.018,
      "left_hip_yaw": -0.018, "right_hip_roll": 0.082, "left_hip_roll": 0.082, "right_hip_pitch": 0,
      "left_hip_pitch": 0, "right_knee": 0.041, "left_knee": 0.041, "right_ankle_pitch": -0.041,
      "left_ankle_pitch": -0.041, "right_ankle_roll": -0.061, "left_ankle_roll": -0.061}'),
    ('bioloid', 'walk_ready', 1, 1.500,
     '{"right_shoulder_pitch": 0.1, "left_shoulder_pitch": 0.1, "right_shoulder_roll": 0.3, "left_shoulder_roll": 0.3,
      "right_elbow": -0.3, "left_elbow": -0.3, "right_hip_yaw": 0, "left_hip_yaw": 0, "right_hip_roll": 0,
      "left_hip_roll": 0, "right_hip_pitch": 0.602, "left_hip_pitch": 0.602, "right_knee": -1.122,
      "left_knee": -1.122, "right_ankle_pitch": 0.561, "left_ankle_pitch": 0.561, "right_ankle_roll": 0,
      "left_ankle_roll": 0}'),
    ('bioloid', 'walk', 1, 0.150,
     '{"right_hip_roll": 0.132, "left_hip_roll": -0.076, "right_hip_pitch": 0.602, "left_hip_pitch": 0.602,
      "right_knee": -1.122, "left_knee": -1.122, "right_ankle_pitch": 0.561, "left_ankle_pitch": 0.561,
      "right_ankle_roll": -0.132, "left_ankle_roll": 0.076}'),
    ('bioloid', 'walk', 2, 0.085,
     '{"right_hip_roll": 0.132, "left_hip_roll": 0.043, "right_hip_pitch": 0.685, "left_hip_pitch": 0.602,
      "right_knee": -1.287, "left_knee": -1.122, "right_ankle_pitch": 0.644, "left_ankle_pitch": 0.561,
      "right_ankle_roll": -0.132, "left_ankle_roll": 0.076}'),
    ('bioloid', 'walk', 3, 0.085,
     '{"right_hip_roll": 0.132, "left_hip_roll": 0.043, "right_hip_pitch": 0.685, "left_hip_pitch": 0.602,
      "right_knee": -1.287, "left_knee": -1.122, "right_ankle_pitch": 0.644, "left_ankle_pitch": 0.561,
      "right_ankle_roll": -0.132, "left_ankle_roll": 0.076}'),
    ('bioloid', 'walk', 4, 0.085,
     '{"right_hip_roll": 0.132, "left_hip_roll": -0.076, "right_hip_pitch": 0.602, "left_hip_pitch": 0.602,
      "right_knee": -1.122, "left_knee": -1.122, "right_ankle_pitch": 0.561, "left_ankle_pitch": 0.561,
      "right_ankle_roll": -0.132, "left_ankle_roll": 0.076}'),
    ('bioloid', 'walk', 5, 0.150,
     '{"right_hip_roll": -0.076, "left_hip_roll": 0.132, "right_hip_pitch": 0.602, "left_hip_pitch": 0.602,
      "right_knee": -1.122, "left_knee": -1.122, "right_ankle_pitch": 0.561, "left_ankle_pitch": 0.561,
      "right_ankle_roll": 0.076, "left_ankle_roll": -0.132}'),
    ('bioloid', 'walk', 6, 0.085,
     '{"right_hip_roll": 0.043, "left_hip_roll": 0.132, "right_hip_pitch": 0.602, "left_hip_pitch": 0.685,
      "right_knee": -1.122, "left_knee": -1.287, "right_ankle_pitch": 0.561, "left_ankle_pitch": 0.644,
      "right_ankle_roll": 0.076, "left_ankle_roll": -0.132}'),
    ('bioloid', 'walk', 7, 0.085,
     '{"right_hip_roll": 0.043, "left_hip_roll": 0.132, "right_hip_pitch": 0.602, "left_hip_pitch": 0.685,
      "right_knee": -1.122, "left_knee": -1.287, "right_ankle_pitch": 0.561, "left_ankle_pitch": 0.644,
      "right_ankle_roll": 0.076, "left_ankle_roll": -0.132}'),
    ('bioloid', 'walk', 8, 0.085,
     '{"right_hip_roll": -0.076, "left_hip_roll": 0.132, "right_hip_pitch": 0.602, "left_hip_pitch": 0.602,
      "right_knee": -1.122, "left_knee": -1.122, "right_ankle_pitch": 0.561, "left_ankle_pitch": 0.561,
      "right_ankle_roll": 0.076, "left_ankle_roll": -0.132}'),
    ('bioloid', 'walk_ahead', 1, 0.127,
     '{"right_hip_roll": 0.14, "left_hip_roll": -0.064, "right_hip_pitch": 0.485, "left_hip_pitch": 0.617,
      "right_knee": -1.08, "left_knee": -1.096, "right_ankle_pitch": 0.641, "left_ankle_pitch": 0.525,
      "right_ankle_roll": -0.14, "left_ankle_roll": 0.064}'),
    ('bioloid', 'walk_ahead', 2, 0.090,
     '{"right_hip_roll": 0.14, "left_hip_roll": 0.062, "right_hip_pitch": 0.589, "left_hip_pitch": 0.587,
      "right_knee": -1.234, "left_knee": -1.097, "right_ankle_pitch": 0.691, "left_ankle_pitch": 0.556,
      "right_ankle_roll": -0.14, "left_ankle_roll": 0.064}'),
    ('bioloid', 'walk_ahead', 3, 0.090,
     '{"right_hip_roll": 0.14, "left_hip_roll": 0.062, "right_hip_pitch": 0.659, "left_hip_pitch": 0.52,
      "right_knee": -1.242, "left_knee": -1.089, "right_ankle_pitch": 0.629, "left_ankle_pitch": 0.615,
      "right_ankle_roll": -0.14, "left_ankle_roll": 0.064}'),
    ('bioloid', 'walk_ahead', 4, 0.090,
     '{"right_hip_roll": 0.14, "left_hip_roll": -0.064, "right_hip_pitch": 0.617, "left_hip_pitch": 0.485,
      "right_knee": -1.096, "left_knee": -1.08, "right_ankle_pitch": 0.525, "left_ankle_pitch": 0.641,
      "right_ankle_roll": -0.14, "left_ankle_roll": 0.064}'),
    ('bioloid', 'walk_ahead', 5, 0.127,
     '{"right_hip_roll": -0.064, "left_hip_roll": 0.14, "right_hip_pitch": 0.617, "left_hip_pitch": 0.485,
      "right_knee": -1.096, "left_knee": -1.08, "right_ankle_pitch": 0.525, "left_ankle_pitch": 0.641,
      "right_ankle_roll": 0.064, "left_ankle_roll": -0.14}'),
    ('bioloid', 'walk_ahead', 6, 0.090,
     '{"right_hip_roll": 0.062, "left_hip_roll": 0.14, "right_hip_pitch": 0.587, "left_hip_pitch": 0.589,
      "right_knee": -1.097, "left_knee": -1.234, "right_ankle_pitch": 0.556, "left_ankle_pitch": 0.691,
      "right_ankle_roll": 0.064, "left_ankle_roll": -0.14}'),
    ('bioloid', 'walk_ahead', 7, 0.090,
     '{"right_hip_roll": 0.062, "left_hip_roll": 0.14, "right_hip_pitch": 0.52, "left_hip_pitch": 0.659,
      "right_knee": -1.089, "left_knee": -1.242, "right_ankle_pitch": 0.615, "left_ankle_pitch": 0.629,
      "right_ankle_roll": 0.064, "left_ankle_roll": -0.14}'),
    ('bioloid', 'walk_ahead', 8, 0.090,
     '{"right_hip_roll": -0.064, "left_hip_roll": 0.14, "right_hip_pitch": 0.485, "left_hip_pitch": 0.617,
      "right_knee": -1.08, "left_knee": -1.096, "right_ankle_pitch": 0.641, "left_ankle_pitch": 0.525,
      "right_ankle_roll": 0.064, "left_ankle_roll": -0.14}'),
    ('bioloid', 'walk_back', 1, 0.137,
     '{"right_hip_roll": 0.1, "left_hip_roll": -0.05, "right_hip_pitch": 0.667, "left_hip_pitch": 0.463,
      "right_knee": -1.056, "left_knee": -1.051, "right_ankle_pitch": 0.435, "left_ankle_pitch": 0.634,
      "right_ankle_roll": -0.1, "left_ankle_roll": 0.05}'),
    ('bioloid', 'walk_back', 2, 0.086,
     '{"right_hip_roll": 0.1, "left_hip_roll": 0.064, "right_hip_pitch": 0.687, "left_hip_pitch": 0.521,
      "right_knee": -1.192, "left_knee": -1.065, "right_ankle_pitch": 0.552, "left_ankle_pitch": 0.591,
      "right_ankle_roll": -0.1, "left_ankle_roll": 0.05}'),
    ('bioloid', 'walk_back', 3, 0.086,
     '{"right_hip_roll": 0.1, "left_hip_roll": 0.064, "right_hip_pitch": 0.581, "left_hip_pitch": 0.623,
      "right_knee": -1.19, "left_knee": -1.068, "right_ankle_pitch": 0.655, "left_ankle_pitch": 0.491,
      "right_ankle_roll": -0.1, "left_ankle_roll": 0.05}'),
    ('bioloid', 'walk_back', 4, 0.086,
     '{"right_hip_roll": 0.1, "left_hip_roll": -0.05, "right_hip_pitch": 0.463, "left_hip_pitch": 0.667,
      "right_knee": -1.051, "left_knee": -1.056, "right_ankle_pitch": 0.634, "left_ankle_pitch": 0.435,
      "right_ankle_roll": -0.1, "left_ankle_roll": 0.05}'),
    ('bioloid', 'walk_back', 5, 0.137,
     '{"right_hip_roll": -0.05, "left_hip_roll": 0.1, "right_hip_pitch": 0.463, "left_hip_pitch": 0.667,
      "right_knee": -1.051, "left_knee": -1.056, "right_ankle_pitch": 0.634, "left_ankle_pitch": 0.435,
      "right_ankle_roll": 0.05, "left_ankle_roll": -0.1}'),
    ('bioloid', 'walk_back', 6, 0.086,
     '{"right_hip_roll": 0.064, "left_hip_roll": 0.1, "right_hip_pitch": 0.521, "left_hip_pitch": 0.687,
      "right_knee": -1.065, "left_knee": -1.192, "right_ankle_pitch": 0.591, "left_ankle_pitch": 0.552,
      "right_ankle_roll": 0.05, "left_ankle_roll": -0.1}'),
    ('bioloid', 'walk_back', 7, 0.086,
     '{"right_hip_roll": 0.064, "left_hip_roll": 0.1, "right_hip_pitch": 0.623, "left_hip_pitch": 0.581,
      "right_knee": -1.068, "left_knee": -1.19, "right_ankle_pitch": 0.491, "left_ankle_pitch": 0.655,
      "right_ankle_roll": 0.05, "left_ankle_roll": -0.1}'),
    ('bioloid', 'walk_back', 8, 0.086,
     '{"right_hip_roll": -0.05, "left_hip_roll": 0.1, "right_hip_pitch": 0.667, "left_hip_pitch": 0.463,
      "right_knee": -1.056, "left_knee": -1.051, "right_ankle_pitch": 0.435, "left_ankle_pitch": 0.634,
      "right_ankle_roll": 0.05, "left_ankle_roll": -0.1}'),
    ('bioloid', 'turn_left', 1, 0.127,
     '{"right_hip_yaw": 0.07, "left_hip_yaw": 0.07, "right_hip_roll": 0.133, "left_hip_roll": -0.067,
      "right_hip_pitch": 0.601, "left_hip_pitch": 0.586, "right_knee": -1.097, "left_knee": -1.097,
      "right_ankle_pitch": 0.548, "left_ankle_pitch": 0.564, "right_ankle_roll": -0.133, "left_ankle_roll": 0.067}'),
    ('bioloid', 'turn_left', 2, 0.078,
     '{"right_hip_yaw": 0.035, "left_hip_yaw": 0.035, "right_hip_roll": 0.133, "left_hip_roll": 0.033,
      "right_hip_pitch": 0.67, "left_hip_pitch": 0.59, "right_knee": -1.242, "left_knee": -1.097,
      "right_ankle_pitch": 0.625, "left_ankle_pitch": 0.56, "right_ankle_roll": -0.133, "left_ankle_roll": 0.067}'),
    ('bioloid', 'turn_left', 3, 0.078,
     '{"right_hip_yaw": -0.035, "left_hip_yaw": -0.035, "right_hip_roll": 0.133, "left_hip_roll": 0.033,
      "right_hip_pitch": 0.662, "left_hip_pitch": 0.598, "right_knee": -1.242, "left_knee": -1.097,
      "right_ankle_pitch": 0.633, "left_ankle_pitch": 0.552, "right_ankle_roll": -0.133, "left_ankle_roll": 0.067}'),
    ('bioloid', 'turn_left', 4, 0.078,
     '{"right_hip_yaw": -0.07, "left_hip_yaw": -0.07, "right_hip_roll": 0.133, "left_hip_roll": -0.067,
      "right_hip_pitch": 0.586, "left_hip_pitch": 0.601, "right_knee": -1.097, "left_knee": -1.097,
      "right_ankle_pitch": 0.564, "left_ankle_pitch": 0.548, "right_ankle_roll": -0.133, "left_ankle_roll": 0.067}'),
    ('bioloid', 'turn_left', 5, 0.127,
     '{"right_hip_yaw": -0.07, "left_hip_yaw": -0.07, "right_hip_roll": -0.067, "left_hip_roll": 0.133,
      "right_hip_pitch": 0.586, "left_hip_pitch": 0.601, "right_knee": -1.097, "left_knee": -1.097,
      "right_ankle_pitch": 0.564, "left_ankle_pitch": 0.548, "right_ankle_roll": 0.067, "left_ankle_roll": -0.133}'),
    ('bioloid', 'turn_left', 6, 0.078,
     '{"right_hip_yaw": -0.035, "left_hip_yaw": -0.035, "right_hip_roll": 0.033, "left_hip_roll": 0.133,
      "right_hip_pitch": 0.59, "left_hip_pitch": 0.67, "right_knee": -1.097, "left_knee": -1.242,
      "right_ankle_pitch": 0.56, "left_ankle_pitch": 0.625, "right_ankle_roll": 0.067, "left_ankle_roll": -0.133}'),
    ('bioloid', 'turn_left', 7, 0.078,
     '{"right_hip_yaw": 0.035, "left_hip_yaw": 0.035, "right_hip_roll": 0.033, "left_hip_roll": 0.133,
      "right_hip_pitch": 0.598, "left_hip_pitch": 0.662, "right_knee": -1.097, "left_knee": -1.242,
      "right_ankle_pitch": 0.552, "left_ankle_pitch": 0.633, "right_ankle_roll": 0.067, "left_ankle_roll": -0.133}'),
    ('bioloid', 'turn_left', 8, 0.078,
     '{"right_hip_yaw": 0.07, "left_hip_yaw": 0.07, "right_hip_roll": -0.067, "left_hip_roll": 0.133,
      "right_hip_pitch": 0.601, "left_hip_pitch": 0.586, "right_knee": -1.097, "left_knee": -1.097,
      "right_ankle_pitch": 0.548, "left_ankle_pitch": 0.564, "right_ankle_roll": 0.067, "left_ankle_roll": -0.133}');


INSERT INTO verb (robot, word, pattern, target, payload, role, help) VALUES
    ('bioloid', 'j', '/j/{joint}/{angle_deg}', 'joints.move', NULL, 'operate',
     'Move a joint to an angle in degrees from its zero, at 30 degrees a second, such as /j/left_shoulder_pitch/60'),
    ('bioloid', 'j', '/j/{joint}/{angle_deg}/{speed_dps}', 'joints.move', NULL, 'operate',
     'The same at so many degrees a second, such as /j/left_shoulder_pitch/60/90; never faster than its row says'),
    ('bioloid', 'torque', '/torque/on', 'joints.torque', '{"on": true}', 'operate',
     'Switch the torque of all joints on: each stays where it is'),
    ('bioloid', 'torque', '/torque/on/{joints}', 'joints.torque', '{"on": true}', 'operate',
     'Switch the torque of a joint on, or of several, such as /torque/on/left_elbow,right_elbow'),
    ('bioloid', 'torque', '/torque/off/{joints}', 'joints.torque', '{"on": false}', 'operate',
     'Let go of a joint, or of several, such as /torque/off/left_elbow, so that a hand can move it'),
    ('bioloid', 'torque', '/torque/off', 'joints.torque', '{"on": false}', 'operate',
     'Let go of all joints, once you have said that you mean it'),
    ('bioloid', 'torque', '/torque/off/all', 'joints.torque', '{"on": false, "confirmed": true}', 'operate',
     'Let go of all joints at once: the robot falls unless it sits or somebody holds it'),
    ('bioloid', 'play', '/play/{motion}', 'motions.play', NULL, 'operate', 'Play a motion once, such as /play/sit'),
    ('bioloid', 'play', '/play/{motion}/{times}', 'motions.play', NULL, 'operate',
     'Play a motion so many times, 1 to 1000; s ends it'),
    ('bioloid', 'play', '/play/{motion}/{times}/{speed}', 'motions.play', NULL, 'operate',
     'The same faster or slower, 0.1 to 3 times as its rows say'),
    ('bioloid', 'mirror', '/mirror/{motion}', 'motions.play', '{"mirror": true}', 'operate',
     'Play a motion with left and right exchanged'),
    ('bioloid', 'mirror', '/mirror/{motion}/{times}', 'motions.play', '{"mirror": true}', 'operate',
     'Play a motion with left and right exchanged, so many times'),
    ('bioloid', 'pose', '/pose/{motion}', 'motions.play', '{"times": 1}', 'operate',
     'Take a pose: a motion of one key frame'),
    ('bioloid', 'capture', '/capture/{motion}', 'motions.capture', NULL, 'admin',
     'Write the pose that the joints have now down, as the last key frame of a motion or the first of a new one'),
    ('bioloid', 'capture', '/capture/{motion}/{duration_s}', 'motions.capture', NULL, 'admin',
     'The same, to be reached so many seconds after the frame before'),
    ('bioloid', 'recover', 'recover', 'joints.recover', NULL, 'operate',
     'Take all joints out of what they have latched, such as an overload whose cause is gone; moves nothing'),
    ('bioloid', 'recover', '/recover/{joints}', 'joints.recover', NULL, 'operate',
     'Take a joint, or several, out of what they have latched, such as /recover/left_knee'),
    ('bioloid', 'arm', 'arm', 'power.arm', '{"armed": true}', 'admin',
     'Watch the voltage from now on, and shut the computer down in time; kept over restarts'),
    ('bioloid', 'arm', '/arm/{warn_v}/{shutdown_v}', 'power.arm', '{"armed": true}', 'admin',
     'Watch the voltage as arm does, with a warning below the first and the shutdown below the second, in volts'),
    ('bioloid', 'disarm', 'disarm', 'power.arm', '{"armed": false}', 'admin',
     'Only tell the voltage, and shut nothing down'),
    ('bioloid', 'cancel', 'cancel', 'power.cancel', NULL, 'operate',
     'Let the countdown to the shutdown come to nothing, until the voltage is low anew'),
    ('bioloid', 'relay', '/relay/on', 'ups.relay', '{"on": true}', 'admin', 'Switch the power of the servos on'),
    ('bioloid', 'relay', '/relay/off', 'ups.relay', '{"on": false}', 'admin',
     'Cut the power of the servos: the robot falls unless it sits or somebody holds it'),
    ('bioloid', 'zero', 'zero', 'imu.zero', NULL, 'operate',
     'Take the zero of the inertial unit''s gyro anew; keep the robot still for two seconds'),
    ('bioloid', 'picture', 'picture', 'world.picture', NULL, 'admin',
     'Simulation: save a picture of the robot from its front and its left'),
    ('bioloid', 'pick_up', 'pick_up', 'world.pick_up', NULL, 'operate',
     'Simulation: put the robot back on its feet, in a hand that holds it until its joints have torque'),
    ('bioloid', 'fault', '/fault/{device}/{name}', 'world.fault', '{"value": true}', 'admin',
     'Simulation: let an emulated device fail, such as /fault/servo_bus/unplug'),
    ('bioloid', 'fault', '/fault/{device}/{name}/off', 'world.fault', '{"value": null}', 'admin',
     'Simulation: end a fault of an emulated device'),
    ('bioloid', 'fault', '/fault/{device}/{name}/{value}', 'world.fault', NULL, 'admin',
     'Simulation: a fault with a number or names, such as /fault/imu/noise/5'),
    ('bioloid', 'report', '/report/{name}', 'executive.report', NULL, 'view',
     'Show telemetry, settings, statistics, health, events or wiring'),
    ('bioloid', 'restart', '/restart/{name}', 'executive.restart', NULL, 'admin',
     'Stop a capability and start it anew, by its name');


-- ---------------------------------------------------------------------------------------------------------------------
-- UXA-90: a humanoid of one metre, with a main board (UIC) that keeps motions, and 25 SAM servos behind it.

INSERT INTO robot (name, model, description)
VALUES ('uxa90', 'UXA-90 Light', 'A humanoid of one metre: twenty-five servos behind a main board that keeps motions');

INSERT INTO device (robot, name, type, address, settings) VALUES
    ('uxa90', 'main_board', 'uxa90', 'by-id:usb-*-port0', '{}'),
    ('uxa90', 'head_camera', 'camera', '/dev/video0', '{}');

INSERT INTO capability (robot, name, kind, settings, needs, help) VALUES
    ('uxa90', 'servos', 'uxa90', '{"device": "main_board", "sweep_hz": 25}', '[]',
     'The serial line: the main board with its motions, and the servos behind it'),
    ('uxa90', 'joints', 'joints', '{"open_loop": true}', '["servos"]',
     'The joints: who moves them, how far and how fast'),
    ('uxa90', 'motions', 'motions', '{}', '["joints"]',
     'The motions: the main board''s own, and those of key frames'),
    ('uxa90', 'camera_head', 'camera', '{"device": "head_camera", "width_px": 640, "height_px": 480, "on": true}', '[]',
     'The camera in the head'),
    ('uxa90', 'tracking', 'tracking', '{}', '["joints", "camera_head"]',
     'Tracking: the head follows a coloured thing'),
    ('uxa90', 'web', 'web', '{"faces": ["uxa90"]}', '[]',
     'The robot over HTTP, for its phone app and for scripts; on this machine only, unless the settings say otherwise'),
    ('uxa90', 'world', 'humanoid_world',
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

-- Off: nothing on the robot can be reached from other machines, as for lbr.
INSERT INTO capability (robot, name, kind, enabled, settings, help) VALUES
    ('uxa90', 'lan', 'lan', 0, '{"listen": ["tls/0.0.0.0:7447"]}',
     'The door to other machines: whoever has a token comes in');

INSERT INTO channel (robot, source, target, history) VALUES
    ('uxa90', 'joints.setpoint', 'servos.setpoint', 1),
    ('uxa90', 'servos.state', 'joints.servos', 1),
    ('uxa90', 'joints.servos_recover', 'servos.recover', 1),
    ('uxa90', 'joints.state', 'motions.joints', 1),
    ('uxa90', 'joints.result', 'motions.ended', 4),
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
    ('uxa90', 'web.move', 'joints.command', 1),
    ('uxa90', 'web.halt', 'joints.stop', 1),
    ('uxa90', 'web.torque', 'joints.torque', 1),
    ('uxa90', 'web.play', 'motions.play', 1),
    ('uxa90', 'web.stop_motion', 'motions.stop', 1),
    ('uxa90', 'web.take_control', 'servos.take_control', 1),
    ('uxa90', 'web.edit', 'executive.edit', 1),
    ('uxa90', 'web.estop_reset', 'executive.estop_reset', 1);

-- A servo counts 0 to 254 over 269 degrees. Zeros are the factory's nominal ones, signs of legs come from published
-- kinematics, those of arms and head from what motions do; waist, hip yaw and hands are guesses. Limits are what motions
-- of the factory use and a little more, corrected where published tables have left and right swapped; none was measured.
-- Speeds are what the factory's motions ask for, head and neck somewhat more. Mirrored joints count alike: the same
-- angles left and right are a symmetrical pose. At zero it stands upright, arms down.
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

-- What the main board plays by itself; the names that people know it by are rows of `button`. What is kept under a number
-- depends on what was downloaded to that robot: check it, also how long it takes. Key frames say where a motion leads.
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

INSERT INTO motion_step (robot, motion, step, duration_s, positions) VALUES
    ('uxa90', 'basic_motion', 1, 0.4,
     '{"left_ankle_roll": 0.037, "right_ankle_roll": 0, "left_ankle_pitch": 0.462, "right_ankle_pitch": 0.425,
      "left_knee": -0.758, "right_knee": -0.739, "left_hip_pitch": 0.351, "right_hip_pitch": 0.333,
      "left_hip_roll": 0, "right_hip_roll": 0, "left_hip_yaw": 0, "right_hip_yaw": 0,
      "left_shoulder_pitch": -0.314, "right_shoulder_pitch": -0.314, "left_shoulder_roll": 0,
      "right_shoulder_roll": 0, "left_shoulder_yaw": 0.074, "right_shoulder_yaw": 0.074, "left_elbow": -0.591,
      "right_elbow": -0.591, "left_hand": 0, "right_hand": 0, "waist_yaw": 0, "neck_yaw": 0, "head_pitch": 0}'),
    ('uxa90', 'reset', 1, 7,
     '{"left_ankle_roll": 0, "right_ankle_roll": 0, "left_ankle_pitch": 0, "right_ankle_pitch": 0, "left_knee": 0,
      "right_knee": 0, "left_hip_pitch": 0, "right_hip_pitch": 0, "left_hip_roll": 0, "right_hip_roll": 0,
      "left_hip_yaw": 0, "right_hip_yaw": 0, "left_shoulder_pitch": 0, "right_shoulder_pitch": 0,
      "left_shoulder_roll": 0, "right_shoulder_roll": 0, "left_shoulder_yaw": 0, "right_shoulder_yaw": 0,
      "left_elbow": 0, "right_elbow": 0, "left_hand": 0, "right_hand": 0, "waist_yaw": 0, "neck_yaw": 0,
      "head_pitch": 0}');

-- Three tables of the servos. `api`: as phones and scripts have known them, with all that is wrong in it (knees and left
-- shoulder are those of the other side). `factory`: what the factory's motions use. `safe`: what the joints allow.
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

-- The numbers and names by which phones and scripts know the motions.
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

INSERT INTO verb (robot, word, pattern, target, payload, role, help) VALUES
    ('uxa90', 'j', '/j/{joint}/{angle_deg}', 'joints.move', NULL, 'operate',
     'Move a joint to so many degrees, such as /j/neck_yaw/30'),
    ('uxa90', 'j', '/j/{joint}/{angle_deg}/{speed_dps}', 'joints.move', NULL, 'operate',
     'The same at so many degrees a second'),
    ('uxa90', 'torque', '/torque/on', 'joints.torque', '{"on": true}', 'operate',
     'Switch the torque of all joints on, where they are'),
    ('uxa90', 'torque', '/torque/on/{joints}', 'joints.torque', '{"on": true}', 'operate',
     'Switch the torque of one joint on'),
    ('uxa90', 'torque', '/torque/off/{joints}', 'joints.torque', '{"on": false}', 'operate',
     'Let one joint go'),
    ('uxa90', 'torque', '/torque/off', 'joints.torque', '{"on": false}', 'operate',
     'Let all joints go: the robot falls; asks first'),
    ('uxa90', 'torque', '/torque/off/all', 'joints.torque', '{"on": false, "confirmed": true}', 'operate',
     'Let all joints go at once: the robot falls'),
    ('uxa90', 'play', '/play/{motion}', 'motions.play', NULL, 'operate', 'Play a motion once, such as /play/reset'),
    ('uxa90', 'play', '/play/{motion}/{times}', 'motions.play', NULL, 'operate', 'Play a motion several times'),
    ('uxa90', 'play', '/play/{motion}/{times}/{speed}', 'motions.play', NULL, 'operate',
     'The same faster or slower; the main board''s own have one speed'),
    ('uxa90', 'mirror', '/mirror/{motion}', 'motions.play', '{"mirror": true}', 'operate',
     'Play a motion with left and right exchanged; not the main board''s own'),
    ('uxa90', 'capture', '/capture/{motion}', 'motions.capture', NULL, 'admin',
     'Write the pose that the joints have now down as the next key frame of a motion'),
    ('uxa90', 'capture', '/capture/{motion}/{duration_s}', 'motions.capture', NULL, 'admin',
     'The same, to be reached in so many seconds'),
    ('uxa90', 'recover', 'recover', 'joints.recover', NULL, 'operate', 'Take joints out of what they have latched'),
    ('uxa90', 'track', 'track', 'tracking.track', '{"target": "colour"}', 'operate',
     'Have the head follow the coloured thing, until a stop'),
    ('uxa90', 'track', '/track/{target}', 'tracking.track', NULL, 'operate', 'Have the head follow: colour or face'),
    ('uxa90', 'look', 'look', 'tracking.look', NULL, 'operate',
     'Save what the head sees with the coloured thing marked, and say which colour the middle of the picture has'),
    ('uxa90', 'look', '/look/{target}', 'tracking.look', NULL, 'operate', 'Save what the head sees with that marked: colour or face'),
    ('uxa90', 'camera', '/camera/on', 'camera_head.switch', '{"on": true}', 'operate',
     'Switch the camera in the head on'),
    ('uxa90', 'camera', '/camera/off', 'camera_head.switch', '{"on": false}', 'operate',
     'Switch the camera in the head off'),
    ('uxa90', 'snapshot', 'snapshot', 'camera_head.snapshot', NULL, 'operate',
     'Save what the camera in the head sees as a picture, named after the time'),
    ('uxa90', 'pc', 'pc', 'servos.take_control', NULL, 'operate',
     'Take the main board over, so that it passes servo packets on; done by itself before the first move'),
    ('uxa90', 'inquire', '/inquire/{what}', 'servos.inquire', NULL, 'view',
     'Ask the main board: firmware, serial, zeros, imu or last_button'),
    ('uxa90', 'inquire', '/inquire/{what}/{id}', 'servos.inquire', NULL, 'view',
     'Ask a servo: position14, gains, integral_gain, speed, overload, boundary or digital_io'),
    ('uxa90', 'qr', 'qr', 'web.address', NULL, 'view', 'Show where phones find the robot, as a QR code'),
    ('uxa90', 'picture', 'picture', 'world.picture', NULL, 'admin', 'Draw the simulated robot, as a PNG file'),
    ('uxa90', 'ball', '/ball/{x_m}/{y_m}/{z_m}', 'world.ball', NULL, 'operate',
     'Put the ball of the simulated world there: metres ahead, to the left and up of where the robot began'),
    ('uxa90', 'ball', '/ball', 'world.ball', NULL, 'operate', 'Let the ball of the simulated world go its way again'),
    ('uxa90', 'ball', '/ball/gone', 'world.ball', '{"gone": true}', 'operate', 'Take the ball out of the simulated world'),
    ('uxa90', 'pick_up', 'pick_up', 'world.pick_up', NULL, 'operate', 'Put the simulated robot back, as it began'),
    ('uxa90', 'fault', '/fault/{device}/{name}', 'world.fault', '{"value": true}', 'admin',
     'Make something go wrong with an emulated device'),
    ('uxa90', 'fault', '/fault/{device}/{name}/off', 'world.fault', '{"value": null}', 'admin',
     'Have it go right again'),
    ('uxa90', 'fault', '/fault/{device}/{name}/{value}', 'world.fault', NULL, 'admin', 'The same, with a value'),
    ('uxa90', 'report', '/report/{name}', 'executive.report', NULL, 'view',
     'Show telemetry, settings, statistics, health, events or wiring'),
    ('uxa90', 'restart', '/restart/{name}', 'executive.restart', NULL, 'admin', 'Start a capability anew');


-- ---------------------------------------------------------------------------------------------------------------------
-- Triggers that keep the revisions; last, so that a new database begins at revision 0. What lbr itself writes into the
-- robot's row while it runs (last start and shutdown, emergency stop) is no revision.

CREATE TRIGGER robot_insert AFTER INSERT ON robot
BEGIN
    INSERT INTO revision (table_name, row_key, operation, old_row, new_row)
    VALUES ('robot', json_array(NEW.name), 'insert',
            NULL,
            json_object('name', NEW.name, 'model', NEW.model, 'description', NEW.description, 'owner', NEW.owner));
END;

CREATE TRIGGER robot_update AFTER UPDATE ON robot
WHEN (OLD.name, OLD.model, OLD.description, OLD.owner)
     IS NOT (NEW.name, NEW.model, NEW.description, NEW.owner)
BEGIN
    INSERT INTO revision (table_name, row_key, operation, old_row, new_row)
    VALUES ('robot', json_array(NEW.name), 'update',
            json_object('name', OLD.name, 'model', OLD.model, 'description', OLD.description, 'owner', OLD.owner),
            json_object('name', NEW.name, 'model', NEW.model, 'description', NEW.description, 'owner', NEW.owner));
END;

CREATE TRIGGER robot_delete AFTER DELETE ON robot
BEGIN
    INSERT INTO revision (table_name, row_key, operation, old_row, new_row)
    VALUES ('robot', json_array(OLD.name), 'delete',
            json_object('name', OLD.name, 'model', OLD.model, 'description', OLD.description, 'owner', OLD.owner),
            NULL);
END;

CREATE TRIGGER capability_insert AFTER INSERT ON capability
BEGIN
    INSERT INTO revision (table_name, row_key, operation, old_row, new_row)
    VALUES ('capability', json_array(NEW.robot, NEW.name), 'insert',
            NULL,
            json_object('robot', NEW.robot, 'name', NEW.name, 'kind', NEW.kind, 'enabled', NEW.enabled, 'settings',
            NEW.settings, 'restart', NEW.restart, 'needs', NEW.needs, 'help', NEW.help));
END;

CREATE TRIGGER capability_update AFTER UPDATE ON capability
WHEN (OLD.robot, OLD.name, OLD.kind, OLD.enabled, OLD.settings, OLD.restart, OLD.needs, OLD.help)
     IS NOT (NEW.robot, NEW.name, NEW.kind, NEW.enabled, NEW.settings, NEW.restart, NEW.needs, NEW.help)
BEGIN
    INSERT INTO revision (table_name, row_key, operation, old_row, new_row)
    VALUES ('capability', json_array(NEW.robot, NEW.name), 'update',
            json_object('robot', OLD.robot, 'name', OLD.name, 'kind', OLD.kind, 'enabled', OLD.enabled, 'settings',
            OLD.settings, 'restart', OLD.restart, 'needs', OLD.needs, 'help', OLD.help),
            json_object('robot', NEW.robot, 'name', NEW.name, 'kind', NEW.kind, 'enabled', NEW.enabled, 'settings',
            NEW.settings, 'restart', NEW.restart, 'needs', NEW.needs, 'help', NEW.help));
END;

CREATE TRIGGER capability_delete AFTER DELETE ON capability
BEGIN
    INSERT INTO revision (table_name, row_key, operation, old_row, new_row)
    VALUES ('capability', json_array(OLD.robot, OLD.name), 'delete',
            json_object('robot', OLD.robot, 'name', OLD.name, 'kind', OLD.kind, 'enabled', OLD.enabled, 'settings',
            OLD.settings, 'restart', OLD.restart, 'needs', OLD.needs, 'help', OLD.help),
            NULL);
END;

CREATE TRIGGER channel_insert AFTER INSERT ON channel
BEGIN
    INSERT INTO revision (table_name, row_key, operation, old_row, new_row)
    VALUES ('channel', json_array(NEW.robot, NEW.source, NEW.target), 'insert',
            NULL,
            json_object('robot', NEW.robot, 'source', NEW.source, 'target', NEW.target, 'rate_hz', NEW.rate_hz,
            'history', NEW.history, 'enabled', NEW.enabled));
END;

CREATE TRIGGER channel_update AFTER UPDATE ON channel
WHEN (OLD.robot, OLD.source, OLD.target, OLD.rate_hz, OLD.history, OLD.enabled)
     IS NOT (NEW.robot, NEW.source, NEW.target, NEW.rate_hz, NEW.history, NEW.enabled)
BEGIN
    INSERT INTO revision (table_name, row_key, operation, old_row, new_row)
    VALUES ('channel', json_array(NEW.robot, NEW.source, NEW.target), 'update',
            json_object('robot', OLD.robot, 'source', OLD.source, 'target', OLD.target, 'rate_hz', OLD.rate_hz,
            'history', OLD.history, 'enabled', OLD.enabled),
            json_object('robot', NEW.robot, 'source', NEW.source, 'target', NEW.target, 'rate_hz', NEW.rate_hz,
            'history', NEW.history, 'enabled', NEW.enabled));
END;

CREATE TRIGGER channel_delete AFTER DELETE ON channel
BEGIN
    INSERT INTO revision (table_name, row_key, operation, old_row, new_row)
    VALUES ('channel', json_array(OLD.robot, OLD.source, OLD.target), 'delete',
            json_object('robot', OLD.robot, 'source', OLD.source, 'target', OLD.target, 'rate_hz', OLD.rate_hz,
            'history', OLD.history, 'enabled', OLD.enabled),
            NULL);
END;

CREATE TRIGGER device_insert AFTER INSERT ON device
BEGIN
    INSERT INTO revision (table_name, row_key, operation, old_row, new_row)
    VALUES ('device', json_array(NEW.robot, NEW.name), 'insert',
            NULL,
            json_object('robot', NEW.robot, 'name', NEW.name, 'type', NEW.type, 'address', NEW.address, 'settings',
            NEW.settings));
END;

CREATE TRIGGER device_update AFTER UPDATE ON device
WHEN (OLD.robot, OLD.name, OLD.type, OLD.address, OLD.settings)
     IS NOT (NEW.robot, NEW.name, NEW.type, NEW.address, NEW.settings)
BEGIN
    INSERT INTO revision (table_name, row_key, operation, old_row, new_row)
    VALUES ('device', json_array(NEW.robot, NEW.name), 'update',
            json_object('robot', OLD.robot, 'name', OLD.name, 'type', OLD.type, 'address', OLD.address, 'settings',
            OLD.settings),
            json_object('robot', NEW.robot, 'name', NEW.name, 'type', NEW.type, 'address', NEW.address, 'settings',
            NEW.settings));
END;

CREATE TRIGGER device_delete AFTER DELETE ON device
BEGIN
    INSERT INTO revision (table_name, row_key, operation, old_row, new_row)
    VALUES ('device', json_array(OLD.robot, OLD.name), 'delete',
            json_object('robot', OLD.robot, 'name', OLD.name, 'type', OLD.type, 'address', OLD.address, 'settings',
            OLD.settings),
            NULL);
END;

CREATE TRIGGER verb_insert AFTER INSERT ON verb
BEGIN
    INSERT INTO revision (table_name, row_key, operation, old_row, new_row)
    VALUES ('verb', json_array(NEW.robot, NEW.word, NEW.pattern), 'insert',
            NULL,
            json_object('robot', NEW.robot, 'word', NEW.word, 'pattern', NEW.pattern, 'target', NEW.target,
            'payload', NEW.payload, 'role', NEW.role, 'help', NEW.help));
END;

CREATE TRIGGER verb_update AFTER UPDATE ON verb
WHEN (OLD.robot, OLD.word, OLD.pattern, OLD.target, OLD.payload, OLD.role, OLD.help)
     IS NOT (NEW.robot, NEW.word, NEW.pattern, NEW.target, NEW.payload, NEW.role, NEW.help)
BEGIN
    INSERT INTO revision (table_name, row_key, operation, old_row, new_row)
    VALUES ('verb', json_array(NEW.robot, NEW.word, NEW.pattern), 'update',
            json_object('robot', OLD.robot, 'word', OLD.word, 'pattern', OLD.pattern, 'target', OLD.target,
            'payload', OLD.payload, 'role', OLD.role, 'help', OLD.help),
            json_object('robot', NEW.robot, 'word', NEW.word, 'pattern', NEW.pattern, 'target', NEW.target,
            'payload', NEW.payload, 'role', NEW.role, 'help', NEW.help));
END;

CREATE TRIGGER verb_delete AFTER DELETE ON verb
BEGIN
    INSERT INTO revision (table_name, row_key, operation, old_row, new_row)
    VALUES ('verb', json_array(OLD.robot, OLD.word, OLD.pattern), 'delete',
            json_object('robot', OLD.robot, 'word', OLD.word, 'pattern', OLD.pattern, 'target', OLD.target,
            'payload', OLD.payload, 'role', OLD.role, 'help', OLD.help),
            NULL);
END;

CREATE TRIGGER external_command_insert AFTER INSERT ON external_command
BEGIN
    INSERT INTO revision (table_name, row_key, operation, old_row, new_row)
    VALUES ('external_command', json_array(NEW.robot, NEW.name), 'insert',
            NULL,
            json_object('robot', NEW.robot, 'name', NEW.name, 'argv', NEW.argv, 'blocking', NEW.blocking,
            'enabled', NEW.enabled, 'help', NEW.help, 'arguments', NEW.arguments, 'role', NEW.role));
END;

CREATE TRIGGER external_command_update AFTER UPDATE ON external_command
WHEN (OLD.robot, OLD.name, OLD.argv, OLD.blocking, OLD.enabled, OLD.help, OLD.arguments, OLD.role)
     IS NOT (NEW.robot, NEW.name, NEW.argv, NEW.blocking, NEW.enabled, NEW.help, NEW.arguments, NEW.role)
BEGIN
    INSERT INTO revision (table_name, row_key, operation, old_row, new_row)
    VALUES ('external_command', json_array(NEW.robot, NEW.name), 'update',
            json_object('robot', OLD.robot, 'name', OLD.name, 'argv', OLD.argv, 'blocking', OLD.blocking,
            'enabled', OLD.enabled, 'help', OLD.help, 'arguments', OLD.arguments, 'role', OLD.role),
            json_object('robot', NEW.robot, 'name', NEW.name, 'argv', NEW.argv, 'blocking', NEW.blocking,
            'enabled', NEW.enabled, 'help', NEW.help, 'arguments', NEW.arguments, 'role', NEW.role));
END;

CREATE TRIGGER external_command_delete AFTER DELETE ON external_command
BEGIN
    INSERT INTO revision (table_name, row_key, operation, old_row, new_row)
    VALUES ('external_command', json_array(OLD.robot, OLD.name), 'delete',
            json_object('robot', OLD.robot, 'name', OLD.name, 'argv', OLD.argv, 'blocking', OLD.blocking,
            'enabled', OLD.enabled, 'help', OLD.help, 'arguments', OLD.arguments, 'role', OLD.role),
            NULL);
END;

CREATE TRIGGER phrase_insert AFTER INSERT ON phrase
BEGIN
    INSERT INTO revision (table_name, row_key, operation, old_row, new_row)
    VALUES ('phrase', json_array(NEW.name, NEW.language), 'insert',
            NULL,
            json_object('name', NEW.name, 'language', NEW.language, 'text', NEW.text));
END;

CREATE TRIGGER phrase_update AFTER UPDATE ON phrase
WHEN (OLD.name, OLD.language, OLD.text)
     IS NOT (NEW.name, NEW.language, NEW.text)
BEGIN
    INSERT INTO revision (table_name, row_key, operation, old_row, new_row)
    VALUES ('phrase', json_array(NEW.name, NEW.language), 'update',
            json_object('name', OLD.name, 'language', OLD.language, 'text', OLD.text),
            json_object('name', NEW.name, 'language', NEW.language, 'text', NEW.text));
END;

CREATE TRIGGER phrase_delete AFTER DELETE ON phrase
BEGIN
    INSERT INTO revision (table_name, row_key, operation, old_row, new_row)
    VALUES ('phrase', json_array(OLD.name, OLD.language), 'delete',
            json_object('name', OLD.name, 'language', OLD.language, 'text', OLD.text),
            NULL);
END;

CREATE TRIGGER choreography_insert AFTER INSERT ON choreography
BEGIN
    INSERT INTO revision (table_name, row_key, operation, old_row, new_row)
    VALUES ('choreography', json_array(NEW.robot, NEW.dance, NEW.step), 'insert',
            NULL,
            json_object('robot', NEW.robot, 'dance', NEW.dance, 'step', NEW.step, 'power', NEW.power,
            'angle_deg', NEW.angle_deg, 'beats', NEW.beats));
END;

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

CREATE TRIGGER choreography_delete AFTER DELETE ON choreography
BEGIN
    INSERT INTO revision (table_name, row_key, operation, old_row, new_row)
    VALUES ('choreography', json_array(OLD.robot, OLD.dance, OLD.step), 'delete',
            json_object('robot', OLD.robot, 'dance', OLD.dance, 'step', OLD.step, 'power', OLD.power,
            'angle_deg', OLD.angle_deg, 'beats', OLD.beats),
            NULL);
END;

CREATE TRIGGER calibration_insert AFTER INSERT ON calibration
BEGIN
    INSERT INTO revision (table_name, row_key, operation, old_row, new_row)
    VALUES ('calibration', json_array(NEW.robot, NEW.device, NEW.name), 'insert',
            NULL,
            json_object('robot', NEW.robot, 'device', NEW.device, 'name', NEW.name, 'value', NEW.value,
            'measured_at', NEW.measured_at));
END;

CREATE TRIGGER calibration_update AFTER UPDATE ON calibration
WHEN (OLD.robot, OLD.device, OLD.name, OLD.value, OLD.measured_at)
     IS NOT (NEW.robot, NEW.device, NEW.name, NEW.value, NEW.measured_at)
BEGIN
    INSERT INTO revision (table_name, row_key, operation, old_row, new_row)
    VALUES ('calibration', json_array(NEW.robot, NEW.device, NEW.name), 'update',
            json_object('robot', OLD.robot, 'device', OLD.device, 'name', OLD.name, 'value', OLD.value,
            'measured_at', OLD.measured_at),
            json_object('robot', NEW.robot, 'device', NEW.device, 'name', NEW.name, 'value', NEW.value,
            'measured_at', NEW.measured_at));
END;

CREATE TRIGGER calibration_delete AFTER DELETE ON calibration
BEGIN
    INSERT INTO revision (table_name, row_key, operation, old_row, new_row)
    VALUES ('calibration', json_array(OLD.robot, OLD.device, OLD.name), 'delete',
            json_object('robot', OLD.robot, 'device', OLD.device, 'name', OLD.name, 'value', OLD.value,
            'measured_at', OLD.measured_at),
            NULL);
END;

CREATE TRIGGER joint_insert AFTER INSERT ON joint
BEGIN
    INSERT INTO revision (table_name, row_key, operation, old_row, new_row)
    VALUES ('joint', json_array(NEW.robot, NEW.name), 'insert',
            NULL,
            json_object('robot', NEW.robot, 'name', NEW.name, 'device_id', NEW.device_id, 'side', NEW.side,
            'sign', NEW.sign, 'zero_rad', NEW.zero_rad, 'lower_rad', NEW.lower_rad, 'upper_rad', NEW.upper_rad,
            'speed_rps', NEW.speed_rps));
END;

CREATE TRIGGER joint_update AFTER UPDATE ON joint
WHEN (OLD.robot, OLD.name, OLD.device_id, OLD.side, OLD.sign, OLD.zero_rad, OLD.lower_rad, OLD.upper_rad, OLD.speed_rps)
     IS NOT (NEW.robot, NEW.name, NEW.device_id, NEW.side, NEW.sign, NEW.zero_rad, NEW.lower_rad, NEW.upper_rad, NEW.speed_rps)
BEGIN
    INSERT INTO revision (table_name, row_key, operation, old_row, new_row)
    VALUES ('joint', json_array(NEW.robot, NEW.name), 'update',
            json_object('robot', OLD.robot, 'name', OLD.name, 'device_id', OLD.device_id, 'side', OLD.side,
            'sign', OLD.sign, 'zero_rad', OLD.zero_rad, 'lower_rad', OLD.lower_rad, 'upper_rad', OLD.upper_rad,
            'speed_rps', OLD.speed_rps),
            json_object('robot', NEW.robot, 'name', NEW.name, 'device_id', NEW.device_id, 'side', NEW.side,
            'sign', NEW.sign, 'zero_rad', NEW.zero_rad, 'lower_rad', NEW.lower_rad, 'upper_rad', NEW.upper_rad,
            'speed_rps', NEW.speed_rps));
END;

CREATE TRIGGER joint_delete AFTER DELETE ON joint
BEGIN
    INSERT INTO revision (table_name, row_key, operation, old_row, new_row)
    VALUES ('joint', json_array(OLD.robot, OLD.name), 'delete',
            json_object('robot', OLD.robot, 'name', OLD.name, 'device_id', OLD.device_id, 'side', OLD.side,
            'sign', OLD.sign, 'zero_rad', OLD.zero_rad, 'lower_rad', OLD.lower_rad, 'upper_rad', OLD.upper_rad,
            'speed_rps', OLD.speed_rps),
            NULL);
END;

CREATE TRIGGER motion_insert AFTER INSERT ON motion
BEGIN
    INSERT INTO revision (table_name, row_key, operation, old_row, new_row)
    VALUES ('motion', json_array(NEW.robot, NEW.name), 'insert',
            NULL,
            json_object('robot', NEW.robot, 'name', NEW.name, 'help', NEW.help, 'lead_in', NEW.lead_in,
            'lead_out', NEW.lead_out, 'slot', NEW.slot, 'slot_s', NEW.slot_s, 'limp', NEW.limp,
            'builtin', NEW.builtin));
END;

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

CREATE TRIGGER motion_delete AFTER DELETE ON motion
BEGIN
    INSERT INTO revision (table_name, row_key, operation, old_row, new_row)
    VALUES ('motion', json_array(OLD.robot, OLD.name), 'delete',
            json_object('robot', OLD.robot, 'name', OLD.name, 'help', OLD.help, 'lead_in', OLD.lead_in,
            'lead_out', OLD.lead_out, 'slot', OLD.slot, 'slot_s', OLD.slot_s, 'limp', OLD.limp,
            'builtin', OLD.builtin),
            NULL);
END;

CREATE TRIGGER motion_step_insert AFTER INSERT ON motion_step
BEGIN
    INSERT INTO revision (table_name, row_key, operation, old_row, new_row)
    VALUES ('motion_step', json_array(NEW.robot, NEW.motion, NEW.step), 'insert',
            NULL,
            json_object('robot', NEW.robot, 'motion', NEW.motion, 'step', NEW.step, 'duration_s', NEW.duration_s,
            'positions', NEW.positions));
END;

CREATE TRIGGER motion_step_update AFTER UPDATE ON motion_step
WHEN (OLD.robot, OLD.motion, OLD.step, OLD.duration_s, OLD.positions)
     IS NOT (NEW.robot, NEW.motion, NEW.step, NEW.duration_s, NEW.positions)
BEGIN
    INSERT INTO revision (table_name, row_key, operation, old_row, new_row)
    VALUES ('motion_step', json_array(NEW.robot, NEW.motion, NEW.step), 'update',
            json_object('robot', OLD.robot, 'motion', OLD.motion, 'step', OLD.step, 'duration_s', OLD.duration_s,
            'positions', OLD.positions),
            json_object('robot', NEW.robot, 'motion', NEW.motion, 'step', NEW.step, 'duration_s', NEW.duration_s,
            'positions', NEW.positions));
END;

CREATE TRIGGER motion_step_delete AFTER DELETE ON motion_step
BEGIN
    INSERT INTO revision (table_name, row_key, operation, old_row, new_row)
    VALUES ('motion_step', json_array(OLD.robot, OLD.motion, OLD.step), 'delete',
            json_object('robot', OLD.robot, 'motion', OLD.motion, 'step', OLD.step, 'duration_s', OLD.duration_s,
            'positions', OLD.positions),
            NULL);
END;

CREATE TRIGGER motor_insert AFTER INSERT ON motor
BEGIN
    INSERT INTO revision (table_name, row_key, operation, old_row, new_row)
    VALUES ('motor', json_array(NEW.robot, NEW.layer, NEW.id), 'insert',
            NULL,
            json_object('robot', NEW.robot, 'layer', NEW.layer, 'id', NEW.id, 'name', NEW.name,
            'description', NEW.description, 'initial', NEW.initial, 'lowest', NEW.lowest, 'highest', NEW.highest,
            'rest', NEW.rest, 'inverted', NEW.inverted, 'builtin', NEW.builtin));
END;

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

CREATE TRIGGER motor_delete AFTER DELETE ON motor
BEGIN
    INSERT INTO revision (table_name, row_key, operation, old_row, new_row)
    VALUES ('motor', json_array(OLD.robot, OLD.layer, OLD.id), 'delete',
            json_object('robot', OLD.robot, 'layer', OLD.layer, 'id', OLD.id, 'name', OLD.name,
            'description', OLD.description, 'initial', OLD.initial, 'lowest', OLD.lowest, 'highest', OLD.highest,
            'rest', OLD.rest, 'inverted', OLD.inverted, 'builtin', OLD.builtin),
            NULL);
END;

CREATE TRIGGER button_insert AFTER INSERT ON button
BEGIN
    INSERT INTO revision (table_name, row_key, operation, old_row, new_row)
    VALUES ('button', json_array(NEW.robot, NEW.id), 'insert',
            NULL,
            json_object('robot', NEW.robot, 'id', NEW.id, 'name', NEW.name, 'button', NEW.button,
            'motion', NEW.motion, 'builtin', NEW.builtin));
END;

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

CREATE TRIGGER button_delete AFTER DELETE ON button
BEGIN
    INSERT INTO revision (table_name, row_key, operation, old_row, new_row)
    VALUES ('button', json_array(OLD.robot, OLD.id), 'delete',
            json_object('robot', OLD.robot, 'id', OLD.id, 'name', OLD.name, 'button', OLD.button,
            'motion', OLD.motion, 'builtin', OLD.builtin),
            NULL);
END;

-- The audit trail takes rows at its end only, changes none, and gives up none but the oldest.
CREATE TRIGGER audit_insert BEFORE INSERT ON audit
WHEN NEW.previous IS NOT (SELECT hash FROM audit ORDER BY id DESC LIMIT 1) AND EXISTS (SELECT 1 FROM audit)
BEGIN
    SELECT RAISE(ABORT, 'the audit trail goes on where it ended: previous must be the hash of its last row');
END;

CREATE TRIGGER audit_update BEFORE UPDATE ON audit
BEGIN
    SELECT RAISE(ABORT, 'the audit trail is never changed');
END;

CREATE TRIGGER audit_delete BEFORE DELETE ON audit
WHEN OLD.id > (SELECT max(id) FROM audit) - 20000
BEGIN
    SELECT RAISE(ABORT, 'the audit trail gives up only what is older than its newest 20000 rows');
END;

COMMIT;
