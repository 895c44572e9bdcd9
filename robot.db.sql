-- A robot as rows: first the tables of a database, then the rows of the robot lbr. Read it from top to bottom.
--
-- At its first run, `lbr` builds robot.db from this file and from the rows of other robots, such as
-- lbr/robots/bioloid/rows.sql. `sqlite3 robot.db < robot.db.sql && chmod 600 robot.db` builds it without those.
-- Afterwards robot.db is the robot, and this file is not read again. Edit robot.db with any SQLite client, also while the
-- robot runs. A committed edit takes effect within two seconds, or is refused as a whole and reported. `lbr db check`
-- lists wrong rows, `lbr db diff` the differences from these files.
--
-- In your client, switch foreign keys on (`PRAGMA foreign_keys = ON`) and wait for other programs
-- (`PRAGMA busy_timeout = 2000`). Times are ISO 8601 in UTC unless their name ends in _ns. Names are small letters,
-- digits and underscores.

PRAGMA application_id = 0x4C425231;  -- "LBR1": how lbr and file(1) know a robot database
PRAGMA journal_mode = WAL;           -- readers and a writer do not wait for each other
PRAGMA foreign_keys = ON;

BEGIN;

-- The tables, written by docs/generate.py from their declarations: each is a class of rows in lbr.

-- The robots. `lbr` runs one of them; its name is the first part of each of its keys on the bus.
CREATE TABLE robot (
    name          TEXT    NOT NULL PRIMARY KEY  -- its name in profiles and tables
        CHECK (name GLOB '[a-z]*' AND name NOT GLOB '*[^a-z0-9_]*' AND length(name) <= 40),
    model         TEXT    NOT NULL DEFAULT '',  -- the type of robot
    description   TEXT    NOT NULL DEFAULT '',  -- for people
    owner         TEXT    NOT NULL DEFAULT '',  -- for people
    last_start    TEXT,  -- its last start; written by lbr
    last_shutdown TEXT,  -- its last orderly shutdown; written by lbr
    estop_engaged INTEGER NOT NULL DEFAULT 0  -- 1: the emergency stop is latched, also over restarts; written by lbr
        CHECK (estop_engaged IN (0, 1)),
    estop_reason  TEXT    NOT NULL DEFAULT ''  -- the reason of the latch; written by lbr
) STRICT;

-- The capabilities: one process for each enabled row, unless rows share one.
CREATE TABLE capability (
    robot    TEXT    NOT NULL,  -- its robot
    name     TEXT    NOT NULL  -- the second part of its keys; `executive` is lbr itself
        CHECK (name GLOB '[a-z]*' AND name NOT GLOB '*[^a-z0-9_]*' AND length(name) <= 40 AND name <> 'executive'),
    kind     TEXT    NOT NULL  -- a registered kind, or a file in $LBR_HOME/capabilities
        CHECK (kind GLOB '[a-z]*' AND kind NOT GLOB '*[^a-z0-9_]*' AND length(kind) <= 40),
    enabled  INTEGER NOT NULL DEFAULT 1  -- whether it is started
        CHECK (enabled IN (0, 1)),
    settings TEXT    NOT NULL DEFAULT '{}'  -- JSON object: settings of its kind; unknown keys are refused
        CHECK (json_valid(settings) AND json_type(settings) = 'object'),
    restart  TEXT    NOT NULL DEFAULT 'on-failure'  -- when it starts again after its end
        CHECK (restart IN ('never', 'on-failure', 'always')),
    needs    TEXT    NOT NULL DEFAULT '[]'  -- JSON list: the capabilities that start before it
        CHECK (json_valid(needs) AND json_type(needs) = 'array'),
    help     TEXT    NOT NULL DEFAULT '',  -- for people
    process  TEXT    NOT NULL DEFAULT ''  -- the process that it shares; empty: its own
        CHECK (process = '' OR (process GLOB '[a-z]*' AND process NOT GLOB '*[^a-z0-9_]*' AND length(process) <= 40)),
    PRIMARY KEY (robot, name),
    FOREIGN KEY (robot) REFERENCES robot (name) ON UPDATE CASCADE ON DELETE CASCADE
) STRICT;

-- The wiring: each row feeds an output to an input.
CREATE TABLE channel (
    robot   TEXT    NOT NULL,  -- its robot
    source  TEXT    NOT NULL  -- capability.output
        CHECK (source GLOB '[a-z]*.[a-z]*' AND source NOT GLOB '*[^a-z0-9_.]*' AND source NOT GLOB '*.*.*'),
    target  TEXT    NOT NULL  -- capability.input
        CHECK (target GLOB '[a-z]*.[a-z]*' AND target NOT GLOB '*[^a-z0-9_.]*' AND target NOT GLOB '*.*.*'),
    rate_hz REAL  -- most messages a second; NULL: all
        CHECK (rate_hz IS NULL OR (rate_hz > 0 AND rate_hz <= 1000000)),
    history INTEGER NOT NULL DEFAULT 1  -- newest messages that wait for the reader
        CHECK (history BETWEEN 1 AND 64),
    enabled INTEGER NOT NULL DEFAULT 1  -- whether it is wired
        CHECK (enabled IN (0, 1)),
    PRIMARY KEY (robot, source, target),
    FOREIGN KEY (robot) REFERENCES robot (name) ON UPDATE CASCADE ON DELETE CASCADE
) STRICT;

-- The devices. A capability's setting `device` names a row of this table.
CREATE TABLE device (
    robot    TEXT NOT NULL,  -- its robot
    name     TEXT NOT NULL  -- its name in settings and calibrations
        CHECK (name GLOB '[a-z]*' AND name NOT GLOB '*[^a-z0-9_]*' AND length(name) <= 40),
    type     TEXT NOT NULL  -- its type, which the driver's kind names
        CHECK (type GLOB '[a-z]*' AND type NOT GLOB '*[^a-z0-9_]*' AND length(type) <= 40),
    address  TEXT NOT NULL  -- a path, usb:VID:PID[:SERIAL], by-id:GLOB, i2c:BUS:ADDRESS, unix:PATH
        CHECK (length(address) BETWEEN 1 AND 500),
    settings TEXT NOT NULL DEFAULT '{}'  -- JSON object: settings of its type, such as its twin's faults
        CHECK (json_valid(settings) AND json_type(settings) = 'object'),
    PRIMARY KEY (robot, name),
    FOREIGN KEY (robot) REFERENCES robot (name) ON UPDATE CASCADE ON DELETE CASCADE
) STRICT;

-- The words of the console. A word may have several patterns. `/r/{power}/{angle_deg}` puts parts of a line into fields
-- of the target's message, `{text...}` the rest of the line with its slashes. A pattern without a slash is an alias.
CREATE TABLE verb (
    robot   TEXT NOT NULL,  -- its robot
    word    TEXT NOT NULL  -- the first part of the pattern; capital letters count
        CHECK (word GLOB '[A-Za-z]*' AND word NOT GLOB '*[^A-Za-z0-9_]*' AND length(word) <= 40),
    pattern TEXT NOT NULL  -- a line's form, see above
        CHECK (pattern = word OR pattern = '/' || word OR substr(pattern, 1, length(word) + 2) = '/' || word || '/'),
    target  TEXT NOT NULL  -- capability.command, or lbr's own executive.NAME
        CHECK (target GLOB '[a-z]*.[a-z]*' AND target NOT GLOB '*[^a-z0-9_.]*' AND target NOT GLOB '*.*.*'),
    payload TEXT  -- JSON object: fields that the pattern does not bind
        CHECK (payload IS NULL OR (json_valid(payload) AND json_type(payload) = 'object')),
    role    TEXT NOT NULL DEFAULT 'operate'  -- the least role that may use it
        CHECK (role IN ('view', 'operate', 'admin')),
    help    TEXT NOT NULL DEFAULT '',  -- one line for people, with units and bounds
    PRIMARY KEY (robot, word, pattern),
    FOREIGN KEY (robot) REFERENCES robot (name) ON UPDATE CASCADE ON DELETE CASCADE
) STRICT;

-- Programs that the console starts by name, without a shell. `arguments` has an entry for each word after the name; the
-- last words may be left out. An entry is a list of the allowed words, such as ["left", "right"]. Or it is a regular
-- expression for the whole word, such as "[0-9]{1,3}". A word that begins with '-' must be in a list.
CREATE TABLE external_command (
    robot     TEXT    NOT NULL,  -- its robot
    name      TEXT    NOT NULL  -- what to type
        CHECK (name GLOB '[a-z]*' AND name NOT GLOB '*[^a-z0-9_]*' AND length(name) <= 40),
    argv      TEXT    NOT NULL  -- JSON list: the program's path, then its arguments
        CHECK (json_valid(argv) AND json_type(argv) = 'array' AND json_array_length(argv) >= 1),
    blocking  INTEGER NOT NULL DEFAULT 0  -- 1: the console waits for its end; 0: it runs on until `stop NAME`
        CHECK (blocking IN (0, 1)),
    enabled   INTEGER NOT NULL DEFAULT 1  -- whether it is offered
        CHECK (enabled IN (0, 1)),
    help      TEXT    NOT NULL DEFAULT '',  -- one line for people
    arguments TEXT  -- JSON list: the words after the name, see above
        CHECK (arguments IS NULL OR (json_valid(arguments) AND json_type(arguments) = 'array')),
    role      TEXT    NOT NULL DEFAULT 'operate'  -- the least role that may start and end it
        CHECK (role IN ('view', 'operate', 'admin')),
    PRIMARY KEY (robot, name),
    FOREIGN KEY (robot) REFERENCES robot (name) ON UPDATE CASCADE ON DELETE CASCADE
) STRICT;

-- Behaviours: state tables, edited in any spreadsheet (docs/behaviours.md).
CREATE TABLE behaviour (
    robot TEXT NOT NULL,  -- its robot
    name  TEXT NOT NULL  -- its name in commands
        CHECK (name GLOB '[a-z]*' AND name NOT GLOB '*[^a-z0-9_]*' AND length(name) <= 40),
    help  TEXT NOT NULL DEFAULT '',  -- one line for people
    max_s REAL NOT NULL DEFAULT 600  -- longest run; 0: until its end or a stop
        CHECK (max_s BETWEEN 0 AND 86400),
    PRIMARY KEY (robot, name),
    FOREIGN KEY (robot) REFERENCES robot (name) ON UPDATE CASCADE ON DELETE CASCADE
) STRICT;

-- Numbers and names of motions for a face, such as an old phone app. Several numbers may mean one motion.
CREATE TABLE button (
    robot   TEXT    NOT NULL,  -- its robot
    id      INTEGER NOT NULL  -- the number
        CHECK (id BETWEEN 0 AND 9999),
    name    TEXT    NOT NULL  -- its name there; among equal names the lowest number counts
        CHECK (length(name) BETWEEN 1 AND 40),
    button  TEXT    NOT NULL DEFAULT '',  -- the remote control's key
    motion  TEXT    NOT NULL DEFAULT ''  -- the motion; empty: only the controller is taken over
        CHECK (motion = '' OR (motion GLOB '[a-z]*' AND motion NOT GLOB '*[^a-z0-9_]*' AND length(motion) <= 40)),
    builtin INTEGER NOT NULL DEFAULT 0  -- 1: only an edit of the database changes it, never the network
        CHECK (builtin IN (0, 1)),
    PRIMARY KEY (robot, id),
    FOREIGN KEY (robot) REFERENCES robot (name) ON UPDATE CASCADE ON DELETE CASCADE
) STRICT;

-- The dances of the robots: one move after the other, to the beats of a song.
CREATE TABLE choreography (
    robot     TEXT    NOT NULL,  -- its robot
    dance     TEXT    NOT NULL  -- its name in settings and commands
        CHECK (dance GLOB '[a-z]*' AND dance NOT GLOB '*[^a-z0-9_]*' AND length(dance) <= 40),
    step      INTEGER NOT NULL  -- its place in the order, from 1; after the last comes the first
        CHECK (step BETWEEN 1 AND 10000),
    power     REAL    NOT NULL  -- fraction of full power
        CHECK (power BETWEEN 0 AND 1),
    angle_deg REAL    NOT NULL  -- degrees clockwise from ahead
        CHECK (angle_deg BETWEEN -360 AND 360),
    beats     INTEGER NOT NULL DEFAULT 1  -- for how many beats
        CHECK (beats BETWEEN 1 AND 64),
    PRIMARY KEY (robot, dance, step),
    FOREIGN KEY (robot) REFERENCES robot (name) ON UPDATE CASCADE ON DELETE CASCADE
) STRICT;

-- Humanoids: the joints. A servo's angle is `zero_rad + sign * joint angle`.
CREATE TABLE joint (
    robot     TEXT    NOT NULL,  -- its robot
    name      TEXT    NOT NULL  -- its name in motions
        CHECK (name GLOB '[a-z]*' AND name NOT GLOB '*[^a-z0-9_]*' AND length(name) <= 40),
    device_id INTEGER NOT NULL  -- the servo's number on its bus
        CHECK (device_id BETWEEN 0 AND 253),
    side      TEXT    NOT NULL DEFAULT 'centre'  -- its half of the body
        CHECK (side IN ('left', 'right', 'centre')),
    sign      INTEGER NOT NULL DEFAULT 1  -- -1: the servo turns against the joint
        CHECK (sign IN (1, -1)),
    zero_rad  REAL    NOT NULL DEFAULT 0  -- the servo's angle where the joint is at 0
        CHECK (zero_rad BETWEEN -10 AND 10),
    lower_rad REAL    NOT NULL  -- limits of the joint's angle
        CHECK (lower_rad BETWEEN -10 AND 10),
    upper_rad REAL    NOT NULL  -- see lower_rad
        CHECK (upper_rad BETWEEN -10 AND 10),
    speed_rps REAL    NOT NULL  -- the fastest it may move, radians a second
        CHECK (speed_rps > 0 AND speed_rps <= 100),
    bus       TEXT    NOT NULL DEFAULT ''  -- its servo's device row; empty: the only line
        CHECK (bus = '' OR (bus GLOB '[a-z]*' AND bus NOT GLOB '*[^a-z0-9_]*' AND length(bus) <= 40)),
    PRIMARY KEY (robot, name),
    FOREIGN KEY (robot) REFERENCES robot (name) ON UPDATE CASCADE ON DELETE CASCADE,
    CHECK (lower_rad < upper_rad)
) STRICT;

-- The arrangement of the base's wheels: one row. A robot without it has two driven wheels, on the motors `left` and
-- `right`.
CREATE TABLE kinematics (
    robot        TEXT NOT NULL,  -- its robot
    name         TEXT NOT NULL  -- a name for the base
        CHECK (name GLOB '[a-z]*' AND name NOT GLOB '*[^a-z0-9_]*' AND length(name) <= 40),
    kind         TEXT NOT NULL  -- mecanum and omni move sideways
        CHECK (kind IN ('differential', 'skid', 'mecanum', 'omni')),
    track_factor REAL NOT NULL DEFAULT 1  -- factor on the wheels' way in a turn; above 1 where they slip
        CHECK (track_factor BETWEEN 0.5 AND 5),
    PRIMARY KEY (robot, name),
    FOREIGN KEY (robot) REFERENCES robot (name) ON UPDATE CASCADE ON DELETE CASCADE
) STRICT;

-- Humanoids: the named motions. The robot's own controller stores and plays a motion that has a slot.
CREATE TABLE motion (
    robot    TEXT    NOT NULL,  -- its robot
    name     TEXT    NOT NULL  -- its name in commands
        CHECK (name GLOB '[a-z]*' AND name NOT GLOB '*[^a-z0-9_]*' AND length(name) <= 40),
    help     TEXT    NOT NULL DEFAULT '',  -- one line for people
    lead_in  TEXT    NOT NULL DEFAULT ''  -- the motion played once before it; empty: none
        CHECK (lead_in = '' OR (lead_in GLOB '[a-z]*' AND lead_in NOT GLOB '*[^a-z0-9_]*' AND length(lead_in) <= 40)),
    lead_out TEXT    NOT NULL DEFAULT ''  -- the motion played once after it, unless stopped; empty: none
        CHECK (lead_out = '' OR (lead_out GLOB '[a-z]*' AND lead_out NOT GLOB '*[^a-z0-9_]*' AND length(lead_out) <= 40)),
    slot     INTEGER  -- its number in the robot's own controller
        CHECK (slot IS NULL OR (slot BETWEEN 1 AND 255)),
    slot_s   REAL  -- its duration there
        CHECK (slot_s IS NULL OR (slot_s > 0 AND slot_s <= 600)),
    limp     INTEGER NOT NULL DEFAULT 0  -- 1: the controller releases the joints at its end
        CHECK (limp IN (0, 1)),
    builtin  INTEGER NOT NULL DEFAULT 0  -- 1: only an edit of the database changes it, never the network
        CHECK (builtin IN (0, 1)),
    PRIMARY KEY (robot, name),
    FOREIGN KEY (robot) REFERENCES robot (name) ON UPDATE CASCADE ON DELETE CASCADE,
    CHECK ((slot IS NULL) = (slot_s IS NULL))
) STRICT;

-- Numbers, names and limits of servos for a face, such as an old phone app, in the servos' own counts. A face uses one
-- layer. The limits of the joints always hold, too.
CREATE TABLE motor (
    robot       TEXT    NOT NULL,  -- its robot
    layer       TEXT    NOT NULL  -- its name in a face's settings
        CHECK (layer GLOB '[a-z]*' AND layer NOT GLOB '*[^a-z0-9_]*' AND length(layer) <= 40),
    id          INTEGER NOT NULL  -- the servo's number on its bus
        CHECK (id BETWEEN 0 AND 253),
    name        TEXT    NOT NULL  -- for people
        CHECK (length(name) BETWEEN 1 AND 40),
    description TEXT    NOT NULL DEFAULT '',  -- for people
    initial     INTEGER NOT NULL  -- a face's position before the first move
        CHECK (initial BETWEEN 0 AND 16383),
    lowest      INTEGER NOT NULL  -- a position beyond becomes the limit
        CHECK (lowest BETWEEN 0 AND 16383),
    highest     INTEGER NOT NULL  -- see lowest
        CHECK (highest BETWEEN 0 AND 16383),
    rest        INTEGER NOT NULL  -- its position at rest
        CHECK (rest BETWEEN 0 AND 16383),
    inverted    INTEGER NOT NULL DEFAULT 0  -- 1: percentages count from its highest position
        CHECK (inverted IN (0, 1)),
    builtin     INTEGER NOT NULL DEFAULT 0  -- 1: only an edit of the database changes it, never the network
        CHECK (builtin IN (0, 1)),
    PRIMARY KEY (robot, layer, id),
    FOREIGN KEY (robot) REFERENCES robot (name) ON UPDATE CASCADE ON DELETE CASCADE,
    CHECK (lowest < highest)
) STRICT;

-- The phrases of the robots, by name and language.
CREATE TABLE phrase (
    name     TEXT NOT NULL  -- its name in programs
        CHECK (name GLOB '[a-z]*' AND name NOT GLOB '*[^a-z0-9_]*' AND length(name) <= 40),
    language TEXT NOT NULL  -- a language tag in small letters: en, de, pt-br
        CHECK (language GLOB '[a-z][a-z]*' AND language NOT GLOB '*[^a-z0-9-]*' AND length(language) <= 20),
    text     TEXT NOT NULL  -- the spoken text
        CHECK (length(text) BETWEEN 1 AND 1000),
    PRIMARY KEY (name, language)
) STRICT;

-- Sensors of distance: the place of each on the base, its direction, width and reach. Axes are REP 103's: x ahead, y
-- left, from the middle between the wheels; angles are anticlockwise.
CREATE TABLE range_sensor (
    robot     TEXT    NOT NULL,  -- its robot
    name      TEXT    NOT NULL  -- its name in readings, scans and rules
        CHECK (name GLOB '[a-z]*' AND name NOT GLOB '*[^a-z0-9_]*' AND length(name) <= 40),
    kind      TEXT    NOT NULL  -- how it measures
        CHECK (kind IN ('ultrasonic', 'infrared', 'time_of_flight', 'lidar')),
    x_m       REAL    NOT NULL DEFAULT 0  -- ahead of the middle between the wheels
        CHECK (x_m BETWEEN -5 AND 5),
    y_m       REAL    NOT NULL DEFAULT 0  -- to the left of it
        CHECK (y_m BETWEEN -5 AND 5),
    z_m       REAL    NOT NULL DEFAULT 0.2  -- how far above the floor
        CHECK (z_m BETWEEN 0 AND 5),
    yaw_rad   REAL    NOT NULL DEFAULT 0  -- its direction: 0 ahead, 1.5708 left
        CHECK (yaw_rad BETWEEN -7 AND 7),
    pitch_rad REAL    NOT NULL DEFAULT 0  -- downwards; beyond 0.5 it sees no obstacles
        CHECK (pitch_rad BETWEEN -2 AND 2),
    fov_rad   REAL    NOT NULL DEFAULT 0.4  -- its whole width; 6.2832: all around
        CHECK (fov_rad > 0 AND fov_rad <= 6.2832),
    min_m     REAL    NOT NULL DEFAULT 0.02  -- it measures nothing nearer
        CHECK (min_m BETWEEN 0 AND 100),
    max_m     REAL    NOT NULL DEFAULT 4  -- a number above this is a fault
        CHECK (max_m > 0 AND max_m <= 100),
    rays      INTEGER NOT NULL DEFAULT 1  -- 1: one distance; more: a scan of so many
        CHECK (rays BETWEEN 1 AND 4096),
    stop_m    REAL    DEFAULT 0.25  -- the base stops at this distance; NULL: only rules that name the sensor stop it
        CHECK (stop_m IS NULL OR (stop_m > 0 AND stop_m <= 10)),
    PRIMARY KEY (robot, name),
    FOREIGN KEY (robot) REFERENCES robot (name) ON UPDATE CASCADE ON DELETE CASCADE,
    CHECK (min_m < max_m)
) STRICT;

-- The driven wheels. Axes are REP 103's: x ahead, y left, from the middle of the base; angles are anticlockwise.
CREATE TABLE wheel (
    robot      TEXT NOT NULL,  -- its robot
    name       TEXT NOT NULL  -- its name for people
        CHECK (name GLOB '[a-z]*' AND name NOT GLOB '*[^a-z0-9_]*' AND length(name) <= 40),
    motor      TEXT NOT NULL  -- its motor, which may drive several
        CHECK (motor GLOB '[a-z]*' AND motor NOT GLOB '*[^a-z0-9_]*' AND length(motor) <= 40),
    x_m        REAL NOT NULL DEFAULT 0  -- ahead of the middle of the base
        CHECK (x_m BETWEEN -5 AND 5),
    y_m        REAL NOT NULL DEFAULT 0  -- to the left of it
        CHECK (y_m BETWEEN -5 AND 5),
    yaw_rad    REAL NOT NULL DEFAULT 0  -- its direction, motor forward: 0 ahead, 1.5708 left
        CHECK (yaw_rad BETWEEN -7 AND 7),
    roller_rad REAL NOT NULL DEFAULT 0  -- from its axle to its rollers', anticlockwise; mecanum: ±0.7854
        CHECK (roller_rad BETWEEN -1.4 AND 1.4),
    diameter_m REAL NOT NULL  -- of the wheel, rollers included
        CHECK (diameter_m > 0 AND diameter_m <= 2),
    PRIMARY KEY (robot, name),
    FOREIGN KEY (robot) REFERENCES robot (name) ON UPDATE CASCADE ON DELETE CASCADE
) STRICT;

-- The rows of a behaviour. In a state, the first whose conditions all hold is taken. A wrong cell stops only it.
CREATE TABLE behaviour_row (
    robot      TEXT    NOT NULL,  -- its robot
    behaviour  TEXT    NOT NULL,  -- its behaviour
    step       INTEGER NOT NULL  -- the order, from 1
        CHECK (step BETWEEN 1 AND 10000),
    type       TEXT    NOT NULL DEFAULT ''  -- start: the first state; end, fail: good and bad ends; entry: done on entering; #: comment
        CHECK (type IN ('', 'start', 'end', 'fail', 'entry', '#')),
    state      TEXT    NOT NULL DEFAULT ''  -- its state
        CHECK (length(state) <= 80),
    conditions TEXT    NOT NULL DEFAULT '{}'  -- JSON object: column to condition, such as {"Forward": "< 40"}
        CHECK (json_valid(conditions) AND json_type(conditions) = 'object'),
    outputs    TEXT    NOT NULL DEFAULT '{}'  -- JSON object: what is done, such as {"level": "0.2", "angle": "0"}
        CHECK (json_valid(outputs) AND json_type(outputs) = 'object'),
    next_state TEXT    NOT NULL DEFAULT ''  -- the next state
        CHECK (length(next_state) <= 80),
    deadline_s REAL  -- longest time in its state, then the behaviour fails
        CHECK (deadline_s IS NULL OR (deadline_s > 0 AND deadline_s <= 86400)),
    PRIMARY KEY (robot, behaviour, step),
    FOREIGN KEY (robot, behaviour) REFERENCES behaviour (robot, name) ON UPDATE CASCADE ON DELETE CASCADE
) STRICT;

-- Numbers measured on a device by calibration, for its driver's next start.
CREATE TABLE calibration (
    robot       TEXT NOT NULL,  -- its robot
    device      TEXT NOT NULL,  -- the measured device
    name        TEXT NOT NULL  -- the quantity, with its unit as a suffix
        CHECK (name GLOB '[a-z]*' AND name NOT GLOB '*[^a-z0-9_]*' AND length(name) <= 40),
    value       REAL NOT NULL  -- the number
        CHECK (value BETWEEN -1e+300 AND 1e+300),
    measured_at TEXT NOT NULL DEFAULT (strftime('%Y-%m-%dT%H:%M:%fZ', 'now')),  -- when
    PRIMARY KEY (robot, device, name),
    FOREIGN KEY (robot, device) REFERENCES device (robot, name) ON UPDATE CASCADE ON DELETE CASCADE
) STRICT;

-- Humanoids: the key frames of a motion, in order. Those of a motion in a slot show where it leads.
CREATE TABLE motion_step (
    robot      TEXT    NOT NULL,  -- its robot
    motion     TEXT    NOT NULL,  -- its motion
    step       INTEGER NOT NULL  -- the order, from 1
        CHECK (step BETWEEN 1 AND 10000),
    duration_s REAL    NOT NULL  -- from the step before
        CHECK (duration_s > 0 AND duration_s <= 60),
    positions  TEXT    NOT NULL  -- JSON object: joint name to angle in radians; joints left out stay
        CHECK (json_valid(positions) AND json_type(positions) = 'object'),
    stable     INTEGER NOT NULL DEFAULT 0  -- 1: it stands here, and a stopped motion goes on to here
        CHECK (stable IN (0, 1)),
    PRIMARY KEY (robot, motion, step),
    FOREIGN KEY (robot, motion) REFERENCES motion (robot, name) ON UPDATE CASCADE ON DELETE CASCADE
) STRICT;

-- The revision of the schema, written by the migrations in lbr/database/migrations. Do not edit it.
CREATE TABLE alembic_version (
    version_num TEXT NOT NULL PRIMARY KEY  -- a revision's identifier
) STRICT;

-- The roles of people and machines. The token itself is shown once and never stored.
CREATE TABLE user_token (
    name        TEXT NOT NULL PRIMARY KEY  -- its owner
        CHECK (length(name) BETWEEN 1 AND 40),
    role        TEXT NOT NULL  -- look, move, change, or run a share of the robot
        CHECK (role IN ('view', 'operate', 'admin', 'host')),
    hash        TEXT NOT NULL  -- of the token
        CHECK (length(hash) >= 32),
    created_at  TEXT NOT NULL DEFAULT (strftime('%Y-%m-%dT%H:%M:%fZ', 'now')),  -- when
    revoked_at  TEXT,  -- NULL: valid
    expires_at  TEXT,  -- NULL: never
    good_for    TEXT NOT NULL DEFAULT 'both'  -- the doors that it opens
        CHECK (good_for IN ('bus', 'web', 'both')),
    paired_from TEXT  -- the address that paired; NULL: made by hand
        CHECK (paired_from IS NULL OR (length(paired_from) BETWEEN 1 AND 64)),
    called      TEXT  -- what people call it; NULL: by its name
        CHECK (called IS NULL OR (length(called) BETWEEN 1 AND 40))
) STRICT;

-- Every change of a row, written by the triggers at the end of this file.
CREATE TABLE revision (
    id         INTEGER NOT NULL PRIMARY KEY AUTOINCREMENT,  -- counts up, and is never used again
    table_name TEXT    NOT NULL,  -- the table
    row_key    TEXT    NOT NULL  -- JSON list: the row's primary key (after an update, the new one)
        CHECK (json_valid(row_key) AND json_type(row_key) = 'array'),
    operation  TEXT    NOT NULL  -- the operation
        CHECK (operation IN ('insert', 'update', 'delete')),
    old_row    TEXT  -- JSON object: the row before; NULL for an insert
        CHECK (old_row IS NULL OR (json_valid(old_row) AND json_type(old_row) = 'object')),
    new_row    TEXT  -- JSON object: the row after; NULL for a delete
        CHECK (new_row IS NULL OR (json_valid(new_row) AND json_type(new_row) = 'object')),
    changed_at TEXT    NOT NULL DEFAULT (strftime('%Y-%m-%dT%H:%M:%fZ', 'now'))  -- when
) STRICT;

-- The author and the program of each change that lbr made. A revision outside these is another SQLite client's.
CREATE TABLE change (
    first_revision INTEGER NOT NULL PRIMARY KEY,  -- its first revision
    last_revision  INTEGER NOT NULL  -- its last one
        CHECK (last_revision >= first_revision),
    source         TEXT    NOT NULL,  -- an account here, a capability, or a page's user
    program        TEXT    NOT NULL,  -- such as lbr db rollback, executive
    text           TEXT    NOT NULL DEFAULT ''  -- its purpose, in one sentence
) STRICT;

-- Changes of rows on trial (`lbr db apply --within`), written by lbr. The robot goes back to the rows before, unless
-- all changed parts are ready in time. Only the newest row counts.
CREATE TABLE trial (
    revision INTEGER NOT NULL PRIMARY KEY,  -- the last revision that is on trial
    back     INTEGER NOT NULL  -- the revision to go back to
        CHECK (back >= 0),
    robot    TEXT    NOT NULL,  -- the robot whose executive judges
    within_s REAL    NOT NULL  -- the time limit
        CHECK (within_s > 0 AND within_s <= 600),
    state    TEXT    NOT NULL DEFAULT 'running'  -- its result
        CHECK (state IN ('running', 'kept', 'back', 'lost')),
    text     TEXT    NOT NULL DEFAULT ''  -- the reason, in one sentence
) STRICT;

-- Events, written by lbr. The oldest of very many are deleted.
CREATE TABLE event (
    id      INTEGER NOT NULL PRIMARY KEY AUTOINCREMENT,  -- counts up, and is never used again
    wall_ns INTEGER NOT NULL  -- nanoseconds since 1970 by the wall clock
        CHECK (wall_ns >= 0),
    kind    TEXT    NOT NULL,  -- started, stopped, crashed, refused, row_changed ...
    subject TEXT    NOT NULL DEFAULT '',  -- the capability or person
    level   TEXT    NOT NULL DEFAULT 'info'  -- its importance
        CHECK (level IN ('info', 'warning', 'error')),
    text    TEXT    NOT NULL DEFAULT '',  -- one sentence
    data    TEXT    NOT NULL DEFAULT '{}'  -- JSON object: its figures
        CHECK (json_valid(data) AND json_type(data) = 'object')
) STRICT;

-- The audit trail: what people and programs did to the robot. Each hash covers the hash before it, so `lbr db check`
-- finds a changed or missing row. Written by lbr and never changed; the oldest of very many are deleted.
CREATE TABLE audit (
    id       INTEGER NOT NULL PRIMARY KEY AUTOINCREMENT,  -- counts up without a gap
    wall_ns  INTEGER NOT NULL  -- nanoseconds since 1970 by the wall clock
        CHECK (wall_ns >= 0),
    kind     TEXT    NOT NULL,  -- run, shutdown, holder, stopped, estop, login, rows_changed, python ...
    subject  TEXT    NOT NULL,  -- the capability or person
    source   TEXT    NOT NULL,  -- the sender, as robot/capability
    text     TEXT    NOT NULL,  -- one sentence
    previous TEXT    NOT NULL,  -- the hash of the row before; empty for the very first
    hash     TEXT    NOT NULL  -- BLAKE2b over all of this row but itself
) STRICT;

-- The row sets that ran, written by lbr. They show rows that changed without an edit.
CREATE TABLE adopted (
    revision INTEGER NOT NULL PRIMARY KEY,  -- its last revision; 0: none
    hash     TEXT    NOT NULL,  -- BLAKE2b over the rows that make robots
    wall_ns  INTEGER NOT NULL  -- its first adoption, nanoseconds since 1970
        CHECK (wall_ns >= 0)
) STRICT;

-- The revision of this schema, by which an older database is known.
INSERT INTO alembic_version (version_num) VALUES ('0016');


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

-- The ring looks from the outline of the base. The drive's own rules name these sensors, so none has a stop_m, by which it
-- would stop the base itself. An MB1220 measures up to 7.65 m by its makers; from 8 m on its number is a fault.
INSERT INTO range_sensor (robot, name, kind, x_m, y_m, z_m, yaw_rad, pitch_rad, fov_rad, min_m, max_m, rays, stop_m) VALUES
    ('lbr', 'forward', 'ultrasonic', 0.215, 0, 0.3, 0, 0, 0.4, 0.17, 8, 1, NULL),
    ('lbr', 'back', 'ultrasonic', -0.215, 0, 0.3, 3.141592653589793, 0, 0.4, 0.17, 8, 1, NULL),
    ('lbr', 'left', 'ultrasonic', 0, 0.15, 0.3, 1.5707963267948966, 0, 0.4, 0.17, 8, 1, NULL),
    ('lbr', 'right', 'ultrasonic', 0, -0.15, 0.3, -1.5707963267948966, 0, 0.4, 0.17, 8, 1, NULL),
    ('lbr', 'bottom', 'ultrasonic', 0, 0, 0.3, 0, 1.5707963267948966, 0.4, 0.17, 8, 1, NULL);

-- Drive and motor driver share a process: a setpoint reaches the driver at once, and the guard at the motor line covers both. Other
-- light capabilities share processes, too; little is lost when one of them takes the rest along.
INSERT INTO capability (robot, name, kind, process, settings, needs, help) VALUES
    ('lbr', 'motors', 'roboteq', 'base',
     '{"device": "motor_controller",
       "left": {"channel": 1, "direction": -1},
       "right": {"channel": 2, "direction": 1}}', '[]',
     'The motor controller: left wheel on channel 1, mounted mirrored, right wheel on channel 2'),
    ('lbr', 'ranges', 'ultrasonic_ring', 'sensors', '{"device": "range_board"}', '[]',
     'The ring of ultrasonic sensors: distances ahead, behind, left and right'),
    ('lbr', 'imu', 'mpu9150', 'sensors', '{"device": "imu"}', '[]',
     'The inertial unit: acceleration, rate of turn and magnetic field, along its own axes'),
    ('lbr', 'drive', 'drive', 'base', '{}', '["motors", "ranges"]',
     'The base: who drives, how fast and how near to obstacles'),
    ('lbr', 'attitude', 'attitude', 'operations', '{"device": "imu"}', '["imu"]',
     'The attitude: how the body lies, where it looks, how far it turned; and the compass''s calibration'),
    ('lbr', 'odometry', 'odometry', 'operations', '{}', '["motors"]',
     'The odometry: how far the base went by its wheels, and whether they stall or slip'),
    ('lbr', 'battery', 'battery', 'operations', '{}', '["motors"]',
     'The battery: its charge, whether it is being charged, and warnings when it is low'),
    ('lbr', 'speech', 'speech', 'media', '{"device": "speaker"}', '[]',
     'The voice: says texts and phrases, and plays songs'),
    ('lbr', 'dance', 'dance', 'operations', '{}', '["drive", "speech"]',
     'Dances to a song: drives at its beats, within all that the drive allows'),
    ('lbr', 'behaviour', 'behaviour', 'operations', '{}', '["drive"]',
     'The behaviours: state tables that anyone can write, such as patrol; one at a time'),
    ('lbr', 'dock', 'infrared', 'sensors', '{"device": "dock_receiver"}', '[]',
     'The receiver of the charging dock''s infrared beams: which of them it sees'),
    ('lbr', 'beacon', 'beacon', 'operations', '{}', '["drive", "dock"]',
     'The way to the charging dock: looks for its beams and backs up between them, as a table or a person says'),
    ('lbr', 'camera_front', 'camera', 'media', '{"device": "front_camera", "on": true}', '[]',
     'The camera that looks ahead'),
    ('lbr', 'camera_rear', 'camera', 'media',
     '{"device": "rear_camera",
       "controls": {"power_line_frequency": 2, "brightness": 17, "auto_exposure": 1, "exposure_time_absolute": 681}}',
     '[]', 'The camera that looks back'),
    ('lbr', 'cameras', 'cameras', 'operations', '{}', '["camera_front", "camera_rear"]',
     'Which camera is on: one at a time'),
    ('lbr', 'sighting', 'sighting', '',
     '{"field_deg": 72.7, "pitch_deg": 12, "saturation_percent": [75, 100], "diameter_m": 0.14}', '["camera_front"]',
     'Where the front camera sees an orange ball or a face, while that is asked for; it needs the extra vision'),
    ('lbr', 'telemetry', 'telemetry', 'operations', '{}', '[]',
     'All that the robot knows of itself, in one message'),
    ('lbr', 'world', 'world', '', '{}', '[]',
     'The simulated surroundings; runs only under a simulating launch profile');

INSERT INTO capability (robot, name, kind, process, settings, help) VALUES
    ('lbr', 'web', 'web', 'pages', '{"port": 50001, "faces": ["page", "model", "cameras", "call", "recordings"]}',
     'The robot over HTTP: its page and API, stop, cameras; on this machine only, unless the settings say otherwise');

-- The robot's old API, for its old clients: this machine only, without a token only in simulation.
INSERT INTO capability (robot, name, kind, process, settings, help) VALUES
    ('lbr', 'web_api', 'web', 'pages', '{"port": 9145, "faces": ["lbr_original"]}',
     'The robot''s HTTP API of old: drive, speak, telemetry, cameras; moved by this machine alone, or as legacy says');

-- Always on: `UPDATE capability SET enabled = 0 WHERE name = 'box'` switches it off.
INSERT INTO capability (robot, name, kind, settings, help) VALUES
    ('lbr', 'box', 'box', '{}',
     'The black box: what was said of late, and for longer what led to an emergency stop, crash, fault, fall or mark');

-- Off: it needs `pip install 'lbr[foxglove]'`. Then `UPDATE capability SET enabled = 1 WHERE name = 'foxglove'`: docs/foxglove.md.
INSERT INTO capability (robot, name, kind, enabled, settings, help) VALUES
    ('lbr', 'foxglove', 'foxglove', 0, '{"port": 8765}',
     'The robot for Foxglove: its streams, cameras, body and words, at ws://127.0.0.1:8765');

-- Off: it needs a gamepad at the robot's own computer. `lbr devices` proposes its rows, and switches this on: docs/gamepad.md.
INSERT INTO capability (robot, name, kind, enabled, settings, needs, help) VALUES
    ('lbr', 'teleop', 'gamepad_teleop', 0, '{"lines": {"y": "/s/hello"}}', '["drive"]',
     'The hand on a gamepad: drives while its dead-man button is held; a button stops, others say lines');

-- Off: other machines cannot reach the robot. `UPDATE capability SET enabled = 1 WHERE name = 'lan'` lets in holders of a
-- token (`lbr token add NAME`).
INSERT INTO capability (robot, name, kind, enabled, settings, help) VALUES
    ('lbr', 'lan', 'lan', 0, '{"listen": ["tls/0.0.0.0:7447"]}',
     'The door to other machines: whoever has a token comes in');

-- Off: it needs `pip install 'lbr[telepresence]'`. Then `UPDATE capability SET enabled = 1 WHERE name = 'call'`.
INSERT INTO capability (robot, name, kind, enabled, settings, help) VALUES
    ('lbr', 'call', 'call', 0, '{}',
     'Calls from the page: picture and sound both ways; answered at the robot, or at once as its settings say');

-- Off: it needs `pip install 'lbr[mqtt]'`, a broker (the setting host) and for all but stop a token: docs/outside.md.
INSERT INTO capability (robot, name, kind, enabled, settings, help) VALUES
    ('lbr', 'mqtt', 'mqtt', 0,
     '{"words": {"stop": {"do": "stop"}, "dock": {"do": "run", "table": "dock"}, "say": {"do": "say"}}}',
     'The robot at a broker of MQTT: for Home Assistant, for a device shadow of AWS IoT; does what its words allow');

-- Off: it needs `pip install 'lbr[ros2]'`, ROS 2 on rmw_zenoh, and for all but looking and stops a token: docs/ros2.md.
INSERT INTO capability (robot, name, kind, enabled, settings, help) VALUES
    ('lbr', 'ros2', 'ros2', 0, '{"services": {"dock": "/behaviour/run/dock"}}',
     'The robot in ROS 2 by rmw_zenoh: sensors, transforms and cameras out; cmd_vel and services in');

-- Off: it needs a registry (the setting url) and a token of it in credentials/registry.token: docs/registry.md.
INSERT INTO capability (robot, name, kind, enabled, settings, help) VALUES
    ('lbr', 'registrar', 'registrar', 0, '{}',
     'Tells a registry that the robot is up, and how to reach it');

INSERT INTO channel (robot, source, target, history) VALUES
    ('lbr', 'drive.setpoint', 'motors.setpoint', 1),
    ('lbr', 'motors.state', 'drive.motors', 1),
    ('lbr', 'ranges.readings', 'drive.ranges', 1),
    ('lbr', 'imu.sample', 'attitude.samples', 32),
    ('lbr', 'imu.sample', 'telemetry.imu', 32),
    ('lbr', 'drive.state', 'attitude.drive', 1),
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
    ('lbr', 'camera_front.frame', 'sighting.frame', 1),
    ('lbr', 'camera_front.state', 'sighting.camera', 1),
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
    ('lbr', 'camera_front.frame', 'call.frames', 1),
    ('lbr', 'camera_rear.frame', 'call.frames', 1),
    ('lbr', 'camera_front.state', 'call.cameras', 4),
    ('lbr', 'camera_rear.state', 'call.cameras', 4),
    ('lbr', 'web.call_ring', 'call.ring', 1),
    ('lbr', 'web.call_keep', 'call.keep', 1),
    ('lbr', 'web.halt', 'drive.stop', 1),
    ('lbr', 'web.estop_reset', 'executive.estop_reset', 1),
    ('lbr', 'telemetry.package', 'web_api.telemetry', 1),
    ('lbr', 'ranges.readings', 'web_api.ranges', 1),
    ('lbr', 'drive.state', 'web_api.drive', 1),
    ('lbr', 'drive.result', 'web_api.moved', 8),
    ('lbr', 'battery.state', 'web_api.battery', 1),
    ('lbr', 'camera_front.frame', 'web_api.frames', 2),
    ('lbr', 'camera_rear.frame', 'web_api.frames', 2),
    ('lbr', 'camera_front.state', 'web_api.cameras', 4),
    ('lbr', 'camera_rear.state', 'web_api.cameras', 4),
    ('lbr', 'web_api.halt', 'drive.stop', 1),
    ('lbr', 'web_api.drive_command', 'drive.command', 1),
    ('lbr', 'web_api.drive_turn', 'drive.turn', 1),
    ('lbr', 'web_api.drive_heading', 'drive.heading', 1),
    ('lbr', 'web_api.say', 'speech.say', 1),
    ('lbr', 'web_api.select_camera', 'cameras.select', 1),
    ('lbr', 'web_api.dock_heard', 'dock.heard', 1),
    ('lbr', 'web_api.estop_reset', 'executive.estop_reset', 1),
    ('lbr', 'teleop.say', 'executive.line', 1),
    ('lbr', 'ros2.say', 'executive.line', 1);

-- Readers that need only a few messages a second get no more.
INSERT INTO channel (robot, source, target, rate_hz) VALUES
    ('lbr', 'motors.state', 'battery.motors', 5),
    ('lbr', 'battery.say', 'speech.say', NULL),
    ('lbr', 'ranges.readings', 'telemetry.ranges', 10),
    ('lbr', 'motors.state', 'telemetry.motors', 10),
    ('lbr', 'attitude.state', 'telemetry.attitude', 10),
    ('lbr', 'odometry.state', 'telemetry.odometry', 10),
    ('lbr', 'cameras.state', 'telemetry.cameras', 10),
    ('lbr', 'battery.state', 'telemetry.battery', 10),
    ('lbr', 'dock.signal', 'telemetry.dock', 10),
    ('lbr', 'camera_front.frame', 'mqtt.frames', 1),
    ('lbr', 'camera_front.frame', 'ros2.frames', 10),
    ('lbr', 'camera_rear.frame', 'ros2.frames', 10);

-- The kinds of its capabilities bring most of its words; a row with the same pattern replaces one.
INSERT INTO verb (robot, word, pattern, target, payload, role, help) VALUES
    ('lbr', 'f', 'f', 'drive.command', '{"power": 0.25, "angle_deg": 0}', 'operate',
     'Drive ahead at a quarter of full power'),
    ('lbr', 'b', 'b', 'drive.command', '{"power": 0.25, "angle_deg": 180}', 'operate',
     'Drive back at a quarter of full power'),
    ('lbr', 'snapshot', '/snapshot/front', 'camera_front.snapshot', NULL, 'operate',
     'Save what the front camera sees as a picture, named after the time'),
    ('lbr', 'snapshot', '/snapshot/front/{name}', 'camera_front.snapshot', NULL, 'operate',
     'Save what the front camera sees as a picture of that name'),
    ('lbr', 'snapshot', '/snapshot/rear', 'camera_rear.snapshot', NULL, 'operate',
     'Save what the rear camera sees as a picture, named after the time'),
    ('lbr', 'snapshot', '/snapshot/rear/{name}', 'camera_rear.snapshot', NULL, 'operate',
     'Save what the rear camera sees as a picture of that name');

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

-- Behaviours: docs/examples/behaviours has the same tables for a spreadsheet; `lbr behaviour export` writes yours.
INSERT INTO behaviour (robot, name, help, max_s) VALUES
    ('lbr', 'autodock', 'The first lbr''s way to its dock, by the headings and distances of its own room', 600),
    ('lbr', 'dock', 'To the charging dock from anywhere in its room: looks for its beams, backs up between them, sees that it charges', 900),
    ('lbr', 'follow', 'Look for an orange ball, go up to it and stand before it, for ten minutes', 660),
    ('lbr', 'follow_wall', 'Go along the wall on the right, for two minutes', 300),
    ('lbr', 'free_itself', 'Back or go on a little and turn, until it is out of a corner; other tables run it', 300),
    ('lbr', 'go_home', 'Wait until the battery is low, then run dock, and see that it is charged', 0),
    ('lbr', 'greet', 'Say hello to who comes near from ahead, for an hour', 0),
    ('lbr', 'pace', 'Four times to and fro between what is ahead and what is behind', 600),
    ('lbr', 'pacing', 'The first lbr''s pacing: to the west, and back', 600),
    ('lbr', 'patrol', 'Drive about for five minutes, turning where there is room; home when the battery is low', 600),
    ('lbr', 'sensor_testing', 'The first lbr''s test of its sensors: turns that add up to a whole one, then headings', 600);

INSERT INTO behaviour_row (robot, behaviour, step, type, state, conditions, outputs, next_state, deadline_s) VALUES
    ('lbr', 'autodock', 1, '#', 'The first lbr''s way to its dock; headings and distances are of its room', '{}', '{}', '', NULL),
    ('lbr', 'autodock', 2, 'start', 'Announcing', '{}', '{"phrase": "docking"}', 'Initial Orientation', NULL),
    ('lbr', 'autodock', 3, '', 'Initial Orientation', '{"Visits": "<= 5"}', '{"heading": "95", "retry": "2"}', 'Way Point 1', NULL),
    ('lbr', 'autodock', 4, '', 'Initial Orientation', '{"Visits": "> 5"}', '{}', 'Dock Failed', NULL),
    ('lbr', 'autodock', 5, '', 'Way Point 1', '{"heading": "85:100", "Forward": "< 255"}', '{"level": "0.2", "angle": "0", "range": "40", "sensor": "Forward", "retry": "2"}', 'Facing Dock', 90),
    ('lbr', 'autodock', 6, '', 'Way Point 1', '{"heading": "> 100"}', '{}', 'Initial Orientation', NULL),
    ('lbr', 'autodock', 7, '', 'Way Point 1', '{"heading": "< 85"}', '{}', 'Initial Orientation', NULL),
    ('lbr', 'autodock', 8, '', 'Way Point 1', '{"Forward": ">= 255"}', '{}', 'Dock Failed', NULL),
    ('lbr', 'autodock', 9, '', 'Facing Dock', '{"Visits": "> 8"}', '{}', 'Dock Failed', 90),
    ('lbr', 'autodock', 10, '', 'Facing Dock', '{"Forward": "39:41"}', '{"heading": "336", "retry": "2"}', 'Approaching', NULL),
    ('lbr', 'autodock', 11, '', 'Facing Dock', '{"Forward": "< 39"}', '{"level": "0.2", "angle": "180", "distance": "5", "retry": "2"}', 'Facing Dock', NULL),
    ('lbr', 'autodock', 12, '', 'Facing Dock', '{"Forward": "> 41"}', '{"level": "0.2", "angle": "0", "range": "40", "sensor": "Forward", "retry": "2"}', 'Facing Dock', NULL),
    ('lbr', 'autodock', 13, '', 'Approaching', '{"Visits": "> 5"}', '{}', 'Dock Failed', 90),
    ('lbr', 'autodock', 14, '', 'Approaching', '{"heading": "330:345", "Forward": "<= 215", "Right": "20:40"}', '{"level": "0.2", "angle": "0", "range": "40", "sensor": "Forward", "retry": "2"}', 'Dock Orientation', NULL),
    ('lbr', 'autodock', 15, '', 'Approaching', '{"heading": "345:330"}', '{"heading": "336", "retry": "2"}', 'Approaching', NULL),
    ('lbr', 'autodock', 16, '', 'Approaching', '{"Forward": "> 215"}', '{}', 'Dock Failed', NULL),
    ('lbr', 'autodock', 17, '', 'Approaching', '{"heading": "330:345", "Forward": "<= 215", "Right": "< 20 or > 40"}', '{}', 'Dock Failed', NULL),
    ('lbr', 'autodock', 18, '', 'Dock Orientation', '{"Visits": "> 8"}', '{}', 'Dock Failed', 90),
    ('lbr', 'autodock', 19, '', 'Dock Orientation', '{"Forward": "39:41"}', '{"heading": "175", "retry": "2"}', 'Signal Lock', NULL),
    ('lbr', 'autodock', 20, '', 'Dock Orientation', '{"Forward": "< 39"}', '{"level": "0.2", "angle": "180", "distance": "5", "retry": "2"}', 'Dock Orientation', NULL),
    ('lbr', 'autodock', 21, '', 'Dock Orientation', '{"Forward": "> 41"}', '{"level": "0.2", "angle": "0", "range": "40", "sensor": "Forward", "retry": "2"}', 'Dock Orientation', NULL),
    ('lbr', 'autodock', 22, '', 'Signal Lock', '{"Visits": "> 8"}', '{}', 'Dock Failed', 90),
    ('lbr', 'autodock', 23, '', 'Signal Lock', '{"heading": "169:181", "Dock Left": "1", "Dock Right": "1"}', '{"level": "0.25", "angle": "180", "duration": "5", "retry": "2"}', 'Contact', NULL),
    ('lbr', 'autodock', 24, '', 'Signal Lock', '{"heading": "< 169"}', '{"heading": "175", "retry": "2"}', 'Signal Lock', NULL),
    ('lbr', 'autodock', 25, '', 'Signal Lock', '{"heading": "> 181"}', '{"heading": "175", "retry": "2"}', 'Signal Lock', NULL),
    ('lbr', 'autodock', 26, '', 'Signal Lock', '{"Time": ">= 10"}', '{}', 'Dock Failed', NULL),
    ('lbr', 'autodock', 27, '', 'Contact', '{"Amps Left": "<= -5.1", "Amps Right": "<= -5.1"}', '{"level": "0", "angle": "0"}', 'Verifying', 60),
    ('lbr', 'autodock', 28, '', 'Contact', '{"Rear": "< 20", "Amps Left": "0 ± 0.2", "Amps Right": "0 ± 0.2", "Volts": ">= 12.8"}', '{}', 'Verifying', NULL),
    ('lbr', 'autodock', 29, '', 'Contact', '{"Rear": ">= 20", "Amps Left": "0 ± 0.2", "Amps Right": "0 ± 0.2"}', '{}', 'Signal Lock', NULL),
    ('lbr', 'autodock', 30, '', 'Contact', '{"Time": ">= 30"}', '{}', 'Verifying', NULL),
    ('lbr', 'autodock', 31, '', 'Verifying', '{"Rear": "< 20", "Volts": ">= 12.8"}', '{"level": "0", "angle": "0"}', 'Dock Verified', NULL),
    ('lbr', 'autodock', 32, '', 'Verifying', '{"Rear": "< 20", "Volts": "< 12.8", "Visits": "<= 6"}', '{"level": "0", "angle": "0", "duration": "-10"}', 'Verifying', NULL),
    ('lbr', 'autodock', 33, '', 'Verifying', '{"Rear": ">= 20"}', '{}', 'Dock Failed', NULL),
    ('lbr', 'autodock', 34, '', 'Verifying', '{"Visits": "> 6"}', '{}', 'Dock Failed', NULL),
    ('lbr', 'autodock', 35, 'end', 'Dock Verified', '{}', '{"level": "0", "angle": "0", "phrase": "docked"}', '', NULL),
    ('lbr', 'autodock', 36, 'fail', 'Dock Failed', '{}', '{"level": "0", "angle": "0", "phrase": "dock_failed"}', '', NULL),
    ('lbr', 'dock', 1, 'start', 'Announcing', '{}', '{"phrase": "docking"}', 'Looking', NULL),
    ('lbr', 'dock', 2, '', 'Looking', '{"battery.charging": "true"}', '{}', 'Docked', NULL),
    ('lbr', 'dock', 3, '', 'Looking', '{"Visits": "> 8"}', '{}', 'Not reached', NULL),
    ('lbr', 'dock', 4, '', 'Looking', '{"Run Time": ">= 700"}', '{}', 'Not reached', NULL),
    ('lbr', 'dock', 5, '', 'Looking', '{}', '{"beacon": "align"}', 'Searching', NULL),
    ('lbr', 'dock', 6, '', 'Searching', '{"Result": "done"}', '{"beacon": "search"}', 'Driving in', NULL),
    ('lbr', 'dock', 7, '', 'Searching', '{"Result": "!= done"}', '{"beacon": "roam"}', 'Again', NULL),
    ('lbr', 'dock', 8, '', 'Driving in', '{"Result": "done"}', '{"beacon": "follow"}', 'Touching', NULL),
    ('lbr', 'dock', 9, '', 'Driving in', '{"Result": "not_found"}', '{}', 'Elsewhere', NULL),
    ('lbr', 'dock', 10, '', 'Driving in', '{"Result": "!= done"}', '{"beacon": "roam"}', 'Again', NULL),
    ('lbr', 'dock', 11, '', 'Elsewhere', '{"Result": "known", "Visits": "<= 1"}', '{"beacon": "roam"}', 'Again', NULL),
    ('lbr', 'dock', 12, '', 'Elsewhere', '{"Result": "known", "Visits": "> 1"}', '{}', 'No beam', NULL),
    ('lbr', 'dock', 13, '', 'Touching', '{"Result": "done", "battery.charging": "true"}', '{}', 'Verifying', NULL),
    ('lbr', 'dock', 14, '', 'Touching', '{"Result": "done", "Dock Power": "true"}', '{}', 'Verifying', NULL),
    ('lbr', 'dock', 15, '', 'Touching', '{"Result": "done", "beacon.risen_v": ">= 0.08"}', '{}', 'Verifying', NULL),
    ('lbr', 'dock', 16, '', 'Touching', '{"Result": "done", "Time": ">= 6"}', '{"beacon": "withdraw"}', 'Again', NULL),
    ('lbr', 'dock', 17, '', 'Touching', '{"Result": "!= done"}', '{"beacon": "withdraw"}', 'Again', NULL),
    ('lbr', 'dock', 18, '', 'Again', '{"Result": "stale_sensor"}', '{}', 'Blind', NULL),
    ('lbr', 'dock', 19, '', 'Again', '{"Result": "known"}', '{}', 'Looking', NULL),
    ('lbr', 'dock', 20, '', 'Verifying', '{"battery.charging": "true for 1 s"}', '{}', 'Docked', NULL),
    ('lbr', 'dock', 21, '', 'Verifying', '{"Time": ">= 25", "Visits": "<= 3"}', '{"beacon": "withdraw"}', 'Again', NULL),
    ('lbr', 'dock', 22, '', 'Verifying', '{"Time": ">= 100"}', '{}', 'Not charging', NULL),
    ('lbr', 'dock', 23, 'end', 'Docked', '{}', '{"phrase": "docked"}', '', NULL),
    ('lbr', 'dock', 24, 'fail', 'Not reached', '{}', '{"phrase": "dock_failed"}', '', NULL),
    ('lbr', 'dock', 25, 'fail', 'No beam', '{}', '{"phrase": "dock_failed"}', '', NULL),
    ('lbr', 'dock', 26, 'fail', 'Not charging', '{}', '{"phrase": "dock_failed"}', '', NULL),
    ('lbr', 'dock', 27, 'fail', 'Blind', '{}', '{"phrase": "dock_failed"}', '', NULL),
    ('lbr', 'follow', 1, 'start', 'Setting out', '{}', '{"set": "steps = 0; side = 60", "watch": "colour", "speech": "I look for the ball"}', 'Opening', NULL),
    ('lbr', 'follow', 2, '', 'Opening', '{"sighting.pictures_hz": ">= 1"}', '{}', 'Looking', NULL),
    ('lbr', 'follow', 3, '', 'Opening', '{"Time": ">= 10"}', '{}', 'Blind', NULL),
    ('lbr', 'follow', 4, 'entry', 'Looking', '{}', '{"watch": "colour"}', '', NULL),
    ('lbr', 'follow', 5, '', 'Looking', '{"Run Time": ">= 600"}', '{}', 'Done', NULL),
    ('lbr', 'follow', 6, '', 'Looking', '{"sighting.bearing_deg": "> 24"}', '{"set": "steps = 0; side = 60", "turn": "30", "wait": "0.3"}', 'Moved', NULL),
    ('lbr', 'follow', 7, '', 'Looking', '{"sighting.bearing_deg": "8:24"}', '{"set": "steps = 0; side = 60", "turn": "14", "wait": "0.3"}', 'Moved', NULL),
    ('lbr', 'follow', 8, '', 'Looking', '{"sighting.bearing_deg": "< -24"}', '{"set": "steps = 0; side = -60", "turn": "-30", "wait": "0.3"}', 'Moved', NULL),
    ('lbr', 'follow', 9, '', 'Looking', '{"sighting.bearing_deg": "-24:-8"}', '{"set": "steps = 0; side = -60", "turn": "-14", "wait": "0.3"}', 'Moved', NULL),
    ('lbr', 'follow', 10, '', 'Looking', '{"sighting.bearing_deg": "-8:8", "sighting.distance_m": "> 1.6"}', '{"set": "steps = 0", "level": "0.3", "angle": "0", "distance": "50", "wait": "0.3"}', 'Moved', NULL),
    ('lbr', 'follow', 11, '', 'Looking', '{"sighting.bearing_deg": "-8:8", "sighting.distance_m": "1.1:1.6"}', '{"set": "steps = 0", "level": "0.25", "angle": "0", "distance": "25", "wait": "0.3"}', 'Moved', NULL),
    ('lbr', 'follow', 12, '', 'Looking', '{"sighting.bearing_deg": "-8:8", "sighting.distance_m": "0.9:1.1"}', '{"set": "steps = 0", "level": "0.2", "angle": "0", "distance": "15", "wait": "0.3"}', 'Moved', NULL),
    ('lbr', 'follow', 13, '', 'Looking', '{"sighting.bearing_deg": "-8:8"}', '{"set": "steps = 0"}', 'Near', NULL),
    ('lbr', 'follow', 14, '', 'Looking', '{"$steps": ">= 8"}', '{}', 'Lost', NULL),
    ('lbr', 'follow', 15, '', 'Looking', '{"sighting.pictures_hz": ">= 1", "Time": ">= 0.6"}', '{"set": "steps += 1", "turn": "$side", "wait": "0.5"}', 'Searched', NULL),
    ('lbr', 'follow', 16, '', 'Looking', '{"Time": ">= 6"}', '{}', 'Blind', NULL),
    ('lbr', 'follow', 17, '', 'Moved', '{"Result": "done"}', '{}', 'Looking', NULL),
    ('lbr', 'follow', 18, '', 'Moved', '{"Result": "!= done"}', '{"wait": "1.5"}', 'Looking', NULL),
    ('lbr', 'follow', 19, '', 'Searched', '{"Result": "done"}', '{}', 'Looking', NULL),
    ('lbr', 'follow', 20, '', 'Searched', '{"Result": "!= done"}', '{"run": "free_itself"}', 'Freed', NULL),
    ('lbr', 'follow', 21, '', 'Freed', '{"Result": "known"}', '{}', 'Looking', NULL),
    ('lbr', 'follow', 22, '', 'Near', '{"sighting.bearing_deg": "> 12 or < -12"}', '{}', 'Looking', NULL),
    ('lbr', 'follow', 23, '', 'Near', '{"sighting.distance_m": "> 1.1"}', '{}', 'Looking', NULL),
    ('lbr', 'follow', 24, '', 'Near', '{"sighting.bearing_deg": "missing for 1 s"}', '{}', 'Looking', NULL),
    ('lbr', 'follow', 25, '', 'Near', '{"Time": ">= 45"}', '{}', 'Looking', NULL),
    ('lbr', 'follow', 26, 'end', 'Done', '{}', '{"watch": "off", "level": "0", "angle": "0", "speech": "I stay here"}', '', NULL),
    ('lbr', 'follow', 27, 'fail', 'Lost', '{}', '{"watch": "off", "level": "0", "angle": "0", "speech": "I have lost the ball"}', '', NULL),
    ('lbr', 'follow', 28, 'fail', 'Blind', '{}', '{"watch": "off", "level": "0", "angle": "0", "speech": "I cannot see"}', '', NULL),
    ('lbr', 'follow_wall', 1, 'start', 'Setting out', '{}', '{"speech": "I follow the wall on my right"}', 'Along', NULL),
    ('lbr', 'follow_wall', 2, '', 'Along', '{"Run Time": ">= 120"}', '{}', 'Done', NULL),
    ('lbr', 'follow_wall', 3, '', 'Along', '{"Forward": "< 75"}', '{"level": "0", "angle": "0"}', 'Corner', NULL),
    ('lbr', 'follow_wall', 4, '', 'Along', '{"Forward": "missing"}', '{"level": "0", "angle": "0"}', 'Blind', NULL),
    ('lbr', 'follow_wall', 5, '', 'Along', '{"Right": "< 40"}', '{"level": "0.2", "angle": "340"}', 'Going', NULL),
    ('lbr', 'follow_wall', 6, '', 'Along', '{"Right": "40:60"}', '{"level": "0.2", "angle": "0"}', 'Going', NULL),
    ('lbr', 'follow_wall', 7, '', 'Along', '{"Right": "> 60 or missing"}', '{"level": "0.2", "angle": "20"}', 'Going', NULL),
    ('lbr', 'follow_wall', 8, '', 'Going', '{"Result": "done"}', '{}', 'Along', NULL),
    ('lbr', 'follow_wall', 9, '', 'Going', '{"Result": "!= done"}', '{"run": "free_itself"}', 'Freed', NULL),
    ('lbr', 'follow_wall', 10, '', 'Corner', '{}', '{"turn": "-60"}', 'Turned', NULL),
    ('lbr', 'follow_wall', 11, '', 'Turned', '{"Result": "done"}', '{}', 'Along', NULL),
    ('lbr', 'follow_wall', 12, '', 'Turned', '{"Result": "!= done"}', '{"run": "free_itself"}', 'Freed', NULL),
    ('lbr', 'follow_wall', 13, '', 'Freed', '{"Result": "done"}', '{}', 'Along', NULL),
    ('lbr', 'follow_wall', 14, '', 'Freed', '{"Result": "!= done"}', '{}', 'Lost', NULL),
    ('lbr', 'follow_wall', 15, '', 'Blind', '{"Forward": "known"}', '{}', 'Along', NULL),
    ('lbr', 'follow_wall', 16, '', 'Blind', '{"Time": ">= 3"}', '{}', 'Lost', NULL),
    ('lbr', 'follow_wall', 17, 'end', 'Done', '{}', '{"level": "0", "angle": "0", "speech": "The wall is long"}', '', NULL),
    ('lbr', 'follow_wall', 18, 'fail', 'Lost', '{}', '{"level": "0", "angle": "0", "speech": "I have lost the wall"}', '', NULL),
    ('lbr', 'free_itself', 1, 'start', 'Choosing', '{"Visits": "> 15"}', '{}', 'Stuck', NULL),
    ('lbr', 'free_itself', 2, '', 'Choosing', '{"Rear": "> 90"}', '{"level": "0.2", "angle": "180", "distance": "60"}', 'Moved', NULL),
    ('lbr', 'free_itself', 3, '', 'Choosing', '{"Rear": "> 45"}', '{"level": "0.2", "angle": "180", "distance": "25"}', 'Moved', NULL),
    ('lbr', 'free_itself', 4, '', 'Choosing', '{"Forward": "> 75"}', '{"level": "0.2", "angle": "0", "distance": "40"}', 'Moved', NULL),
    ('lbr', 'free_itself', 5, '', 'Choosing', '{"Forward": "> 45"}', '{"level": "0.2", "angle": "0", "distance": "15"}', 'Moved', NULL),
    ('lbr', 'free_itself', 6, '', 'Choosing', '{}', '{"turn": "30 | -30"}', 'Turned', NULL),
    ('lbr', 'free_itself', 7, '', 'Moved', '{"Result": "known"}', '{"turn": "45 | -45 | 90 | -90 | 150 | -150"}', 'Turned', NULL),
    ('lbr', 'free_itself', 8, '', 'Turned', '{"Result": "done"}', '{}', 'Free', NULL),
    ('lbr', 'free_itself', 9, '', 'Turned', '{"Result": "!= done"}', '{}', 'Choosing', NULL),
    ('lbr', 'free_itself', 10, 'end', 'Free', '{}', '{}', '', NULL),
    ('lbr', 'free_itself', 11, 'fail', 'Stuck', '{}', '{}', '', NULL),
    ('lbr', 'go_home', 1, 'start', 'Watching', '{"battery.charging": "true"}', '{}', 'On the dock', NULL),
    ('lbr', 'go_home', 2, '', 'Watching', '{"battery.level": "low or critical for 10 s"}', '{"phrase": "battery_low"}', 'Going home', NULL),
    ('lbr', 'go_home', 3, '', 'Going home', '{}', '{"run": "dock"}', 'On the dock', NULL),
    ('lbr', 'go_home', 4, '', 'On the dock', '{"battery.charging": "true for 5 s"}', '{}', 'Home', NULL),
    ('lbr', 'go_home', 5, '', 'On the dock', '{"battery.charging": "false for 60 s"}', '{}', 'Not charging', NULL),
    ('lbr', 'go_home', 6, 'end', 'Home', '{}', '{"phrase": "charging"}', '', NULL),
    ('lbr', 'go_home', 7, 'fail', 'Not charging', '{}', '{"phrase": "dock_failed"}', '', NULL),
    ('lbr', 'greet', 1, 'start', 'Looking ahead', '{}', '{}', 'Waiting', NULL),
    ('lbr', 'greet', 2, '', 'Waiting', '{"Run Time": ">= 3600"}', '{}', 'Done', NULL),
    ('lbr', 'greet', 3, '', 'Waiting', '{"Forward": "becomes < 120"}', '{"speech": "Hello | Good day | Nice to see you"}', 'Met', NULL),
    ('lbr', 'greet', 4, '', 'Met', '{"Forward": "> 150 for 3 s"}', '{}', 'Waiting', NULL),
    ('lbr', 'greet', 5, '', 'Met', '{"Time": ">= 60"}', '{}', 'Waiting', NULL),
    ('lbr', 'greet', 6, 'end', 'Done', '{}', '{}', '', NULL),
    ('lbr', 'greet', 7, 'fail', 'Failed', '{}', '{}', '', NULL),
    ('lbr', 'pace', 1, 'start', 'Ready', '{}', '{"set": "laps = 0", "speech": "I am pacing"}', 'Walking', NULL),
    ('lbr', 'pace', 2, '', 'Walking', '{"$laps": ">= 4"}', '{}', 'Done', 60),
    ('lbr', 'pace', 3, '', 'Walking', '{}', '{"set": "laps += 1", "level": "0.3", "angle": "0", "range": "90", "retry": "2"}', 'Turning', NULL),
    ('lbr', 'pace', 4, '', 'Turning', '{"Result": "done or obstacle"}', '{"turn": "180", "retry": "2"}', 'Turned', 60),
    ('lbr', 'pace', 5, '', 'Turning', '{"Result": "!= done and != obstacle"}', '{}', 'Stuck', NULL),
    ('lbr', 'pace', 6, '', 'Turned', '{"Result": "done"}', '{}', 'Walking', NULL),
    ('lbr', 'pace', 7, '', 'Turned', '{"Result": "!= done"}', '{"run": "free_itself"}', 'Freed', NULL),
    ('lbr', 'pace', 8, '', 'Freed', '{"Result": "done"}', '{}', 'Walking', NULL),
    ('lbr', 'pace', 9, '', 'Freed', '{"Result": "!= done"}', '{}', 'Stuck', NULL),
    ('lbr', 'pace', 10, 'end', 'Done', '{}', '{"speech": "That was it"}', '', NULL),
    ('lbr', 'pace', 11, 'fail', 'Stuck', '{}', '{"speech": "I am stuck"}', '', NULL),
    ('lbr', 'pacing', 1, '#', 'The first lbr''s pacing between two walls: west and back', '{}', '{}', '', NULL),
    ('lbr', 'pacing', 2, 'start', 'Initial Orientation', '{"Visits": "> 5"}', '{}', 'Pacing Failure', NULL),
    ('lbr', 'pacing', 3, '', 'Initial Orientation', '{}', '{"heading": "270", "retry": "2"}', 'Westerly', NULL),
    ('lbr', 'pacing', 4, '', 'Westerly', '{"heading": "255:280"}', '{"level": "0.25", "angle": "0", "range": "57", "sensor": "Forward", "retry": "2"}', 'Facing East', 90),
    ('lbr', 'pacing', 5, '', 'Westerly', '{"heading": "280:255"}', '{}', 'Initial Orientation', NULL),
    ('lbr', 'pacing', 6, '', 'Facing East', '{"Forward": "54:60"}', '{"heading": "90", "retry": "2"}', 'Easterly', 20),
    ('lbr', 'pacing', 7, '', 'Facing East', '{"Visits": "> 5"}', '{}', 'Pacing Failure', NULL),
    ('lbr', 'pacing', 8, '', 'Facing East', '{"Forward": "> 60"}', '{"level": "0.25", "angle": "0", "range": "57", "sensor": "Forward", "retry": "2"}', 'Facing East', NULL),
    ('lbr', 'pacing', 9, '', 'Facing East', '{"Forward": "< 54"}', '{"heading": "90", "retry": "2"}', 'Easterly', NULL),
    ('lbr', 'pacing', 10, '', 'Easterly', '{"Visits": "> 5"}', '{}', 'Pacing Failure', 90),
    ('lbr', 'pacing', 11, '', 'Easterly', '{"heading": "75:100"}', '{"level": "0.25", "angle": "0", "range": "40", "sensor": "Forward", "retry": "2"}', 'Facing West', NULL),
    ('lbr', 'pacing', 12, '', 'Easterly', '{"heading": "100:75"}', '{"heading": "90", "retry": "2"}', 'Easterly', NULL),
    ('lbr', 'pacing', 13, '', 'Facing West', '{"Forward": "37:43"}', '{"heading": "270", "retry": "2"}', 'At Ease', 20),
    ('lbr', 'pacing', 14, '', 'Facing West', '{"Visits": "> 5"}', '{}', 'Pacing Failure', NULL),
    ('lbr', 'pacing', 15, '', 'Facing West', '{"Forward": "> 43"}', '{"level": "0.25", "angle": "0", "range": "40", "sensor": "Forward", "retry": "2"}', 'Facing West', NULL),
    ('lbr', 'pacing', 16, '', 'Facing West', '{"Forward": "< 37"}', '{"heading": "270", "retry": "2"}', 'At Ease', NULL),
    ('lbr', 'pacing', 17, 'end', 'At Ease', '{}', '{"level": "0", "angle": "0"}', '', NULL),
    ('lbr', 'pacing', 18, 'fail', 'Pacing Failure', '{}', '{"level": "0", "angle": "0"}', '', NULL),
    ('lbr', 'patrol', 1, 'start', 'Setting out', '{}', '{"speech": "I am on patrol"}', 'Deciding', NULL),
    ('lbr', 'patrol', 2, '', 'Deciding', '{"Run Time": ">= 300"}', '{}', 'Home again', NULL),
    ('lbr', 'patrol', 3, '', 'Deciding', '{"battery.level": "low or critical"}', '{}', 'Home again', NULL),
    ('lbr', 'patrol', 4, '', 'Deciding', '{"Forward": "> 90"}', '{"level": "0.3", "angle": "0", "range": "70"}', 'Moved', 60),
    ('lbr', 'patrol', 5, '', 'Deciding', '{"Left": "> 120"}', '{"turn": "-90"}', 'Moved', NULL),
    ('lbr', 'patrol', 6, '', 'Deciding', '{"Right": "> 120"}', '{"turn": "90"}', 'Moved', NULL),
    ('lbr', 'patrol', 7, '', 'Deciding', '{}', '{"turn": "180"}', 'Moved', NULL),
    ('lbr', 'patrol', 8, '', 'Moved', '{"Result": "done"}', '{}', 'Deciding', NULL),
    ('lbr', 'patrol', 9, '', 'Moved', '{"Result": "!= done"}', '{"run": "free_itself"}', 'Freed', NULL),
    ('lbr', 'patrol', 10, '', 'Freed', '{"Result": "done"}', '{}', 'Deciding', NULL),
    ('lbr', 'patrol', 11, '', 'Freed', '{"Result": "!= done"}', '{}', 'Stuck', NULL),
    ('lbr', 'patrol', 12, 'end', 'Home again', '{}', '{"speech": "My patrol is over"}', '', NULL),
    ('lbr', 'patrol', 13, 'fail', 'Stuck', '{}', '{"speech": "I cannot go on with my patrol"}', '', NULL),
    ('lbr', 'sensor_testing', 1, '#', 'The first lbr''s test of its sensors: a whole turn in parts and then headings', '{}', '{}', '', NULL),
    ('lbr', 'sensor_testing', 2, 'start', 'Begin', '{}', '{"speech": "I am testing my sensors"}', 'Right', NULL),
    ('lbr', 'sensor_testing', 3, '', 'Right', '{}', '{"turn": "90", "retry": "2"}', 'Left', NULL),
    ('lbr', 'sensor_testing', 4, '', 'Left', '{}', '{"turn": "-90", "retry": "2"}', 'About', NULL),
    ('lbr', 'sensor_testing', 5, '', 'About', '{}', '{"turn": "180", "retry": "2"}', 'About again', NULL),
    ('lbr', 'sensor_testing', 6, '', 'About again', '{}', '{"turn": "180", "retry": "2"}', 'Forty', NULL),
    ('lbr', 'sensor_testing', 7, '', 'Forty', '{}', '{"turn": "40", "retry": "2"}', 'Sixty', NULL),
    ('lbr', 'sensor_testing', 8, '', 'Sixty', '{}', '{"turn": "60", "retry": "2"}', 'Back to the origin', NULL),
    ('lbr', 'sensor_testing', 9, '', 'Back to the origin', '{}', '{"turn": "-100", "speech": "Now the compass", "retry": "2"}', 'East', NULL),
    ('lbr', 'sensor_testing', 10, '', 'East', '{}', '{"heading": "90", "retry": "2"}', 'North East', NULL),
    ('lbr', 'sensor_testing', 11, '', 'North East', '{}', '{"heading": "45", "retry": "2"}', 'West', NULL),
    ('lbr', 'sensor_testing', 12, '', 'West', '{}', '{"heading": "270", "retry": "2"}', 'North', NULL),
    ('lbr', 'sensor_testing', 13, '', 'North', '{}', '{"heading": "0"}', 'South West', NULL),
    ('lbr', 'sensor_testing', 14, '', 'South West', '{}', '{"heading": "225", "retry": "2"}', 'South', NULL),
    ('lbr', 'sensor_testing', 15, '', 'South', '{}', '{"heading": "180", "retry": "2"}', 'End', NULL),
    ('lbr', 'sensor_testing', 16, 'end', 'End', '{}', '{"speech": "That was the test"}', '', NULL),
    ('lbr', 'sensor_testing', 17, 'fail', 'Failed', '{}', '{"speech": "My sensors failed the test"}', '', NULL);


-- ---------------------------------------------------------------------------------------------------------------------
-- The triggers that write the revisions, written by docs/generate.py, too. They come last, so that a new database begins at
-- revision 0. Values that lbr writes into the robot's row while it runs (start, shutdown, emergency stop) are not a revision.

CREATE TRIGGER robot_insert AFTER INSERT ON robot
BEGIN
    INSERT INTO revision (table_name, row_key, operation, old_row, new_row)
    VALUES ('robot', json_array(NEW.name), 'insert',
            NULL,
            json_object('name', NEW.name, 'model', NEW.model, 'description', NEW.description,
            'owner', NEW.owner));
END;

CREATE TRIGGER robot_update AFTER UPDATE ON robot
WHEN (OLD.name, OLD.model, OLD.description, OLD.owner)
     IS NOT (NEW.name, NEW.model, NEW.description, NEW.owner)
BEGIN
    INSERT INTO revision (table_name, row_key, operation, old_row, new_row)
    VALUES ('robot', json_array(NEW.name), 'update',
            json_object('name', OLD.name, 'model', OLD.model, 'description', OLD.description,
            'owner', OLD.owner),
            json_object('name', NEW.name, 'model', NEW.model, 'description', NEW.description,
            'owner', NEW.owner));
END;

CREATE TRIGGER robot_delete AFTER DELETE ON robot
BEGIN
    INSERT INTO revision (table_name, row_key, operation, old_row, new_row)
    VALUES ('robot', json_array(OLD.name), 'delete',
            json_object('name', OLD.name, 'model', OLD.model, 'description', OLD.description,
            'owner', OLD.owner),
            NULL);
END;

CREATE TRIGGER capability_insert AFTER INSERT ON capability
BEGIN
    INSERT INTO revision (table_name, row_key, operation, old_row, new_row)
    VALUES ('capability', json_array(NEW.robot, NEW.name), 'insert',
            NULL,
            json_object('robot', NEW.robot, 'name', NEW.name, 'kind', NEW.kind, 'enabled', NEW.enabled,
            'settings', NEW.settings, 'restart', NEW.restart, 'needs', NEW.needs, 'help', NEW.help,
            'process', NEW.process));
END;

CREATE TRIGGER capability_update AFTER UPDATE ON capability
WHEN (OLD.robot, OLD.name, OLD.kind, OLD.enabled, OLD.settings, OLD.restart, OLD.needs, OLD.help, OLD.process)
     IS NOT (NEW.robot, NEW.name, NEW.kind, NEW.enabled, NEW.settings, NEW.restart, NEW.needs, NEW.help, NEW.process)
BEGIN
    INSERT INTO revision (table_name, row_key, operation, old_row, new_row)
    VALUES ('capability', json_array(NEW.robot, NEW.name), 'update',
            json_object('robot', OLD.robot, 'name', OLD.name, 'kind', OLD.kind, 'enabled', OLD.enabled,
            'settings', OLD.settings, 'restart', OLD.restart, 'needs', OLD.needs, 'help', OLD.help,
            'process', OLD.process),
            json_object('robot', NEW.robot, 'name', NEW.name, 'kind', NEW.kind, 'enabled', NEW.enabled,
            'settings', NEW.settings, 'restart', NEW.restart, 'needs', NEW.needs, 'help', NEW.help,
            'process', NEW.process));
END;

CREATE TRIGGER capability_delete AFTER DELETE ON capability
BEGIN
    INSERT INTO revision (table_name, row_key, operation, old_row, new_row)
    VALUES ('capability', json_array(OLD.robot, OLD.name), 'delete',
            json_object('robot', OLD.robot, 'name', OLD.name, 'kind', OLD.kind, 'enabled', OLD.enabled,
            'settings', OLD.settings, 'restart', OLD.restart, 'needs', OLD.needs, 'help', OLD.help,
            'process', OLD.process),
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
            json_object('robot', NEW.robot, 'name', NEW.name, 'type', NEW.type, 'address', NEW.address,
            'settings', NEW.settings));
END;

CREATE TRIGGER device_update AFTER UPDATE ON device
WHEN (OLD.robot, OLD.name, OLD.type, OLD.address, OLD.settings)
     IS NOT (NEW.robot, NEW.name, NEW.type, NEW.address, NEW.settings)
BEGIN
    INSERT INTO revision (table_name, row_key, operation, old_row, new_row)
    VALUES ('device', json_array(NEW.robot, NEW.name), 'update',
            json_object('robot', OLD.robot, 'name', OLD.name, 'type', OLD.type, 'address', OLD.address,
            'settings', OLD.settings),
            json_object('robot', NEW.robot, 'name', NEW.name, 'type', NEW.type, 'address', NEW.address,
            'settings', NEW.settings));
END;

CREATE TRIGGER device_delete AFTER DELETE ON device
BEGIN
    INSERT INTO revision (table_name, row_key, operation, old_row, new_row)
    VALUES ('device', json_array(OLD.robot, OLD.name), 'delete',
            json_object('robot', OLD.robot, 'name', OLD.name, 'type', OLD.type, 'address', OLD.address,
            'settings', OLD.settings),
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

CREATE TRIGGER behaviour_insert AFTER INSERT ON behaviour
BEGIN
    INSERT INTO revision (table_name, row_key, operation, old_row, new_row)
    VALUES ('behaviour', json_array(NEW.robot, NEW.name), 'insert',
            NULL,
            json_object('robot', NEW.robot, 'name', NEW.name, 'help', NEW.help, 'max_s', NEW.max_s));
END;

CREATE TRIGGER behaviour_update AFTER UPDATE ON behaviour
WHEN (OLD.robot, OLD.name, OLD.help, OLD.max_s)
     IS NOT (NEW.robot, NEW.name, NEW.help, NEW.max_s)
BEGIN
    INSERT INTO revision (table_name, row_key, operation, old_row, new_row)
    VALUES ('behaviour', json_array(NEW.robot, NEW.name), 'update',
            json_object('robot', OLD.robot, 'name', OLD.name, 'help', OLD.help, 'max_s', OLD.max_s),
            json_object('robot', NEW.robot, 'name', NEW.name, 'help', NEW.help, 'max_s', NEW.max_s));
END;

CREATE TRIGGER behaviour_delete AFTER DELETE ON behaviour
BEGIN
    INSERT INTO revision (table_name, row_key, operation, old_row, new_row)
    VALUES ('behaviour', json_array(OLD.robot, OLD.name), 'delete',
            json_object('robot', OLD.robot, 'name', OLD.name, 'help', OLD.help, 'max_s', OLD.max_s),
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

CREATE TRIGGER joint_insert AFTER INSERT ON joint
BEGIN
    INSERT INTO revision (table_name, row_key, operation, old_row, new_row)
    VALUES ('joint', json_array(NEW.robot, NEW.name), 'insert',
            NULL,
            json_object('robot', NEW.robot, 'name', NEW.name, 'device_id', NEW.device_id, 'side', NEW.side,
            'sign', NEW.sign, 'zero_rad', NEW.zero_rad, 'lower_rad', NEW.lower_rad, 'upper_rad', NEW.upper_rad,
            'speed_rps', NEW.speed_rps, 'bus', NEW.bus));
END;

CREATE TRIGGER joint_update AFTER UPDATE ON joint
WHEN (OLD.robot, OLD.name, OLD.device_id, OLD.side, OLD.sign, OLD.zero_rad, OLD.lower_rad, OLD.upper_rad,
     OLD.speed_rps, OLD.bus)
     IS NOT (NEW.robot, NEW.name, NEW.device_id, NEW.side, NEW.sign, NEW.zero_rad, NEW.lower_rad, NEW.upper_rad,
     NEW.speed_rps, NEW.bus)
BEGIN
    INSERT INTO revision (table_name, row_key, operation, old_row, new_row)
    VALUES ('joint', json_array(NEW.robot, NEW.name), 'update',
            json_object('robot', OLD.robot, 'name', OLD.name, 'device_id', OLD.device_id, 'side', OLD.side,
            'sign', OLD.sign, 'zero_rad', OLD.zero_rad, 'lower_rad', OLD.lower_rad, 'upper_rad', OLD.upper_rad,
            'speed_rps', OLD.speed_rps, 'bus', OLD.bus),
            json_object('robot', NEW.robot, 'name', NEW.name, 'device_id', NEW.device_id, 'side', NEW.side,
            'sign', NEW.sign, 'zero_rad', NEW.zero_rad, 'lower_rad', NEW.lower_rad, 'upper_rad', NEW.upper_rad,
            'speed_rps', NEW.speed_rps, 'bus', NEW.bus));
END;

CREATE TRIGGER joint_delete AFTER DELETE ON joint
BEGIN
    INSERT INTO revision (table_name, row_key, operation, old_row, new_row)
    VALUES ('joint', json_array(OLD.robot, OLD.name), 'delete',
            json_object('robot', OLD.robot, 'name', OLD.name, 'device_id', OLD.device_id, 'side', OLD.side,
            'sign', OLD.sign, 'zero_rad', OLD.zero_rad, 'lower_rad', OLD.lower_rad, 'upper_rad', OLD.upper_rad,
            'speed_rps', OLD.speed_rps, 'bus', OLD.bus),
            NULL);
END;

CREATE TRIGGER kinematics_insert AFTER INSERT ON kinematics
BEGIN
    INSERT INTO revision (table_name, row_key, operation, old_row, new_row)
    VALUES ('kinematics', json_array(NEW.robot, NEW.name), 'insert',
            NULL,
            json_object('robot', NEW.robot, 'name', NEW.name, 'kind', NEW.kind,
            'track_factor', NEW.track_factor));
END;

CREATE TRIGGER kinematics_update AFTER UPDATE ON kinematics
WHEN (OLD.robot, OLD.name, OLD.kind, OLD.track_factor)
     IS NOT (NEW.robot, NEW.name, NEW.kind, NEW.track_factor)
BEGIN
    INSERT INTO revision (table_name, row_key, operation, old_row, new_row)
    VALUES ('kinematics', json_array(NEW.robot, NEW.name), 'update',
            json_object('robot', OLD.robot, 'name', OLD.name, 'kind', OLD.kind,
            'track_factor', OLD.track_factor),
            json_object('robot', NEW.robot, 'name', NEW.name, 'kind', NEW.kind,
            'track_factor', NEW.track_factor));
END;

CREATE TRIGGER kinematics_delete AFTER DELETE ON kinematics
BEGIN
    INSERT INTO revision (table_name, row_key, operation, old_row, new_row)
    VALUES ('kinematics', json_array(OLD.robot, OLD.name), 'delete',
            json_object('robot', OLD.robot, 'name', OLD.name, 'kind', OLD.kind,
            'track_factor', OLD.track_factor),
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

CREATE TRIGGER motor_insert AFTER INSERT ON motor
BEGIN
    INSERT INTO revision (table_name, row_key, operation, old_row, new_row)
    VALUES ('motor', json_array(NEW.robot, NEW.layer, NEW.id), 'insert',
            NULL,
            json_object('robot', NEW.robot, 'layer', NEW.layer, 'id', NEW.id, 'name', NEW.name,
            'description', NEW.description, 'initial', NEW.initial, 'lowest', NEW.lowest,
            'highest', NEW.highest, 'rest', NEW.rest, 'inverted', NEW.inverted, 'builtin', NEW.builtin));
END;

CREATE TRIGGER motor_update AFTER UPDATE ON motor
WHEN (OLD.robot, OLD.layer, OLD.id, OLD.name, OLD.description, OLD.initial, OLD.lowest, OLD.highest, OLD.rest,
     OLD.inverted, OLD.builtin)
     IS NOT (NEW.robot, NEW.layer, NEW.id, NEW.name, NEW.description, NEW.initial, NEW.lowest, NEW.highest, NEW.rest,
     NEW.inverted, NEW.builtin)
BEGIN
    INSERT INTO revision (table_name, row_key, operation, old_row, new_row)
    VALUES ('motor', json_array(NEW.robot, NEW.layer, NEW.id), 'update',
            json_object('robot', OLD.robot, 'layer', OLD.layer, 'id', OLD.id, 'name', OLD.name,
            'description', OLD.description, 'initial', OLD.initial, 'lowest', OLD.lowest,
            'highest', OLD.highest, 'rest', OLD.rest, 'inverted', OLD.inverted, 'builtin', OLD.builtin),
            json_object('robot', NEW.robot, 'layer', NEW.layer, 'id', NEW.id, 'name', NEW.name,
            'description', NEW.description, 'initial', NEW.initial, 'lowest', NEW.lowest,
            'highest', NEW.highest, 'rest', NEW.rest, 'inverted', NEW.inverted, 'builtin', NEW.builtin));
END;

CREATE TRIGGER motor_delete AFTER DELETE ON motor
BEGIN
    INSERT INTO revision (table_name, row_key, operation, old_row, new_row)
    VALUES ('motor', json_array(OLD.robot, OLD.layer, OLD.id), 'delete',
            json_object('robot', OLD.robot, 'layer', OLD.layer, 'id', OLD.id, 'name', OLD.name,
            'description', OLD.description, 'initial', OLD.initial, 'lowest', OLD.lowest,
            'highest', OLD.highest, 'rest', OLD.rest, 'inverted', OLD.inverted, 'builtin', OLD.builtin),
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

CREATE TRIGGER range_sensor_insert AFTER INSERT ON range_sensor
BEGIN
    INSERT INTO revision (table_name, row_key, operation, old_row, new_row)
    VALUES ('range_sensor', json_array(NEW.robot, NEW.name), 'insert',
            NULL,
            json_object('robot', NEW.robot, 'name', NEW.name, 'kind', NEW.kind, 'x_m', NEW.x_m, 'y_m', NEW.y_m,
            'z_m', NEW.z_m, 'yaw_rad', NEW.yaw_rad, 'pitch_rad', NEW.pitch_rad, 'fov_rad', NEW.fov_rad,
            'min_m', NEW.min_m, 'max_m', NEW.max_m, 'rays', NEW.rays, 'stop_m', NEW.stop_m));
END;

CREATE TRIGGER range_sensor_update AFTER UPDATE ON range_sensor
WHEN (OLD.robot, OLD.name, OLD.kind, OLD.x_m, OLD.y_m, OLD.z_m, OLD.yaw_rad, OLD.pitch_rad, OLD.fov_rad,
     OLD.min_m, OLD.max_m, OLD.rays, OLD.stop_m)
     IS NOT (NEW.robot, NEW.name, NEW.kind, NEW.x_m, NEW.y_m, NEW.z_m, NEW.yaw_rad, NEW.pitch_rad, NEW.fov_rad,
     NEW.min_m, NEW.max_m, NEW.rays, NEW.stop_m)
BEGIN
    INSERT INTO revision (table_name, row_key, operation, old_row, new_row)
    VALUES ('range_sensor', json_array(NEW.robot, NEW.name), 'update',
            json_object('robot', OLD.robot, 'name', OLD.name, 'kind', OLD.kind, 'x_m', OLD.x_m, 'y_m', OLD.y_m,
            'z_m', OLD.z_m, 'yaw_rad', OLD.yaw_rad, 'pitch_rad', OLD.pitch_rad, 'fov_rad', OLD.fov_rad,
            'min_m', OLD.min_m, 'max_m', OLD.max_m, 'rays', OLD.rays, 'stop_m', OLD.stop_m),
            json_object('robot', NEW.robot, 'name', NEW.name, 'kind', NEW.kind, 'x_m', NEW.x_m, 'y_m', NEW.y_m,
            'z_m', NEW.z_m, 'yaw_rad', NEW.yaw_rad, 'pitch_rad', NEW.pitch_rad, 'fov_rad', NEW.fov_rad,
            'min_m', NEW.min_m, 'max_m', NEW.max_m, 'rays', NEW.rays, 'stop_m', NEW.stop_m));
END;

CREATE TRIGGER range_sensor_delete AFTER DELETE ON range_sensor
BEGIN
    INSERT INTO revision (table_name, row_key, operation, old_row, new_row)
    VALUES ('range_sensor', json_array(OLD.robot, OLD.name), 'delete',
            json_object('robot', OLD.robot, 'name', OLD.name, 'kind', OLD.kind, 'x_m', OLD.x_m, 'y_m', OLD.y_m,
            'z_m', OLD.z_m, 'yaw_rad', OLD.yaw_rad, 'pitch_rad', OLD.pitch_rad, 'fov_rad', OLD.fov_rad,
            'min_m', OLD.min_m, 'max_m', OLD.max_m, 'rays', OLD.rays, 'stop_m', OLD.stop_m),
            NULL);
END;

CREATE TRIGGER wheel_insert AFTER INSERT ON wheel
BEGIN
    INSERT INTO revision (table_name, row_key, operation, old_row, new_row)
    VALUES ('wheel', json_array(NEW.robot, NEW.name), 'insert',
            NULL,
            json_object('robot', NEW.robot, 'name', NEW.name, 'motor', NEW.motor, 'x_m', NEW.x_m,
            'y_m', NEW.y_m, 'yaw_rad', NEW.yaw_rad, 'roller_rad', NEW.roller_rad, 'diameter_m', NEW.diameter_m));
END;

CREATE TRIGGER wheel_update AFTER UPDATE ON wheel
WHEN (OLD.robot, OLD.name, OLD.motor, OLD.x_m, OLD.y_m, OLD.yaw_rad, OLD.roller_rad, OLD.diameter_m)
     IS NOT (NEW.robot, NEW.name, NEW.motor, NEW.x_m, NEW.y_m, NEW.yaw_rad, NEW.roller_rad, NEW.diameter_m)
BEGIN
    INSERT INTO revision (table_name, row_key, operation, old_row, new_row)
    VALUES ('wheel', json_array(NEW.robot, NEW.name), 'update',
            json_object('robot', OLD.robot, 'name', OLD.name, 'motor', OLD.motor, 'x_m', OLD.x_m,
            'y_m', OLD.y_m, 'yaw_rad', OLD.yaw_rad, 'roller_rad', OLD.roller_rad, 'diameter_m', OLD.diameter_m),
            json_object('robot', NEW.robot, 'name', NEW.name, 'motor', NEW.motor, 'x_m', NEW.x_m,
            'y_m', NEW.y_m, 'yaw_rad', NEW.yaw_rad, 'roller_rad', NEW.roller_rad, 'diameter_m', NEW.diameter_m));
END;

CREATE TRIGGER wheel_delete AFTER DELETE ON wheel
BEGIN
    INSERT INTO revision (table_name, row_key, operation, old_row, new_row)
    VALUES ('wheel', json_array(OLD.robot, OLD.name), 'delete',
            json_object('robot', OLD.robot, 'name', OLD.name, 'motor', OLD.motor, 'x_m', OLD.x_m,
            'y_m', OLD.y_m, 'yaw_rad', OLD.yaw_rad, 'roller_rad', OLD.roller_rad, 'diameter_m', OLD.diameter_m),
            NULL);
END;

CREATE TRIGGER behaviour_row_insert AFTER INSERT ON behaviour_row
BEGIN
    INSERT INTO revision (table_name, row_key, operation, old_row, new_row)
    VALUES ('behaviour_row', json_array(NEW.robot, NEW.behaviour, NEW.step), 'insert',
            NULL,
            json_object('robot', NEW.robot, 'behaviour', NEW.behaviour, 'step', NEW.step, 'type', NEW.type,
            'state', NEW.state, 'conditions', NEW.conditions, 'outputs', NEW.outputs,
            'next_state', NEW.next_state, 'deadline_s', NEW.deadline_s));
END;

CREATE TRIGGER behaviour_row_update AFTER UPDATE ON behaviour_row
WHEN (OLD.robot, OLD.behaviour, OLD.step, OLD.type, OLD.state, OLD.conditions, OLD.outputs, OLD.next_state,
     OLD.deadline_s)
     IS NOT (NEW.robot, NEW.behaviour, NEW.step, NEW.type, NEW.state, NEW.conditions, NEW.outputs, NEW.next_state,
     NEW.deadline_s)
BEGIN
    INSERT INTO revision (table_name, row_key, operation, old_row, new_row)
    VALUES ('behaviour_row', json_array(NEW.robot, NEW.behaviour, NEW.step), 'update',
            json_object('robot', OLD.robot, 'behaviour', OLD.behaviour, 'step', OLD.step, 'type', OLD.type,
            'state', OLD.state, 'conditions', OLD.conditions, 'outputs', OLD.outputs,
            'next_state', OLD.next_state, 'deadline_s', OLD.deadline_s),
            json_object('robot', NEW.robot, 'behaviour', NEW.behaviour, 'step', NEW.step, 'type', NEW.type,
            'state', NEW.state, 'conditions', NEW.conditions, 'outputs', NEW.outputs,
            'next_state', NEW.next_state, 'deadline_s', NEW.deadline_s));
END;

CREATE TRIGGER behaviour_row_delete AFTER DELETE ON behaviour_row
BEGIN
    INSERT INTO revision (table_name, row_key, operation, old_row, new_row)
    VALUES ('behaviour_row', json_array(OLD.robot, OLD.behaviour, OLD.step), 'delete',
            json_object('robot', OLD.robot, 'behaviour', OLD.behaviour, 'step', OLD.step, 'type', OLD.type,
            'state', OLD.state, 'conditions', OLD.conditions, 'outputs', OLD.outputs,
            'next_state', OLD.next_state, 'deadline_s', OLD.deadline_s),
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

CREATE TRIGGER motion_step_insert AFTER INSERT ON motion_step
BEGIN
    INSERT INTO revision (table_name, row_key, operation, old_row, new_row)
    VALUES ('motion_step', json_array(NEW.robot, NEW.motion, NEW.step), 'insert',
            NULL,
            json_object('robot', NEW.robot, 'motion', NEW.motion, 'step', NEW.step,
            'duration_s', NEW.duration_s, 'positions', NEW.positions, 'stable', NEW.stable));
END;

CREATE TRIGGER motion_step_update AFTER UPDATE ON motion_step
WHEN (OLD.robot, OLD.motion, OLD.step, OLD.duration_s, OLD.positions, OLD.stable)
     IS NOT (NEW.robot, NEW.motion, NEW.step, NEW.duration_s, NEW.positions, NEW.stable)
BEGIN
    INSERT INTO revision (table_name, row_key, operation, old_row, new_row)
    VALUES ('motion_step', json_array(NEW.robot, NEW.motion, NEW.step), 'update',
            json_object('robot', OLD.robot, 'motion', OLD.motion, 'step', OLD.step,
            'duration_s', OLD.duration_s, 'positions', OLD.positions, 'stable', OLD.stable),
            json_object('robot', NEW.robot, 'motion', NEW.motion, 'step', NEW.step,
            'duration_s', NEW.duration_s, 'positions', NEW.positions, 'stable', NEW.stable));
END;

CREATE TRIGGER motion_step_delete AFTER DELETE ON motion_step
BEGIN
    INSERT INTO revision (table_name, row_key, operation, old_row, new_row)
    VALUES ('motion_step', json_array(OLD.robot, OLD.motion, OLD.step), 'delete',
            json_object('robot', OLD.robot, 'motion', OLD.motion, 'step', OLD.step,
            'duration_s', OLD.duration_s, 'positions', OLD.positions, 'stable', OLD.stable),
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
