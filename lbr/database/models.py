"""Every table as SQLAlchemy knows it; robot.db.sql builds them, and a test keeps the two the same.

Flags are 0 or 1 and JSON is text, so that a bad row can be read and named. Without the ORM: its import alone would make
every start and every command slower.
"""

from sqlalchemy import REAL, Column, FetchedValue, ForeignKey, ForeignKeyConstraint, Integer, MetaData, Table, Text

METADATA = MetaData()
_CASCADE = "CASCADE"


def _robot() -> "Column[str]":
    return Column("robot", Text, ForeignKey("robot.name", onupdate=_CASCADE, ondelete=_CASCADE), primary_key=True)


ROBOT = Table(
    "robot",
    METADATA,
    Column("name", Text, primary_key=True),
    Column("model", Text, nullable=False),
    Column("description", Text, nullable=False),
    Column("owner", Text, nullable=False),
    Column("last_start", Text),
    Column("last_shutdown", Text),
    Column("estop_engaged", Integer, nullable=False),
    Column("estop_reason", Text, nullable=False),
)
"""The robots that the file describes."""

CAPABILITY = Table(
    "capability",
    METADATA,
    _robot(),
    Column("name", Text, primary_key=True),
    Column("kind", Text, nullable=False),
    Column("enabled", Integer, nullable=False),
    Column("settings", Text, nullable=False),
    Column("restart", Text, nullable=False),
    Column("needs", Text, nullable=False),
    Column("help", Text, nullable=False),
)
"""What runs."""

CHANNEL = Table(
    "channel",
    METADATA,
    _robot(),
    Column("source", Text, primary_key=True),
    Column("target", Text, primary_key=True),
    Column("rate_hz", REAL),
    Column("history", Integer, nullable=False),
    Column("enabled", Integer, nullable=False),
)
"""Which output feeds which input."""

DEVICE = Table(
    "device",
    METADATA,
    _robot(),
    Column("name", Text, primary_key=True),
    Column("type", Text, nullable=False),
    Column("address", Text, nullable=False),
    Column("settings", Text, nullable=False),
)
"""What is plugged in."""

VERB = Table(
    "verb",
    METADATA,
    _robot(),
    Column("word", Text, primary_key=True),
    Column("pattern", Text, primary_key=True),
    Column("target", Text, nullable=False),
    Column("payload", Text),
    Column("role", Text, nullable=False),
    Column("help", Text, nullable=False),
)
"""The console's vocabulary."""

EXTERNAL_COMMAND = Table(
    "external_command",
    METADATA,
    _robot(),
    Column("name", Text, primary_key=True),
    Column("argv", Text, nullable=False),
    Column("blocking", Integer, nullable=False),
    Column("enabled", Integer, nullable=False),
    Column("help", Text, nullable=False),
    Column("arguments", Text),
    Column("role", Text, nullable=False),
)
"""Programs started by name."""

PHRASE = Table(
    "phrase",
    METADATA,
    Column("name", Text, primary_key=True),
    Column("language", Text, primary_key=True),
    Column("text", Text, nullable=False),
)
"""What the robots say."""

CHOREOGRAPHY = Table(
    "choreography",
    METADATA,
    _robot(),
    Column("dance", Text, primary_key=True),
    Column("step", Integer, primary_key=True),
    Column("power", REAL, nullable=False),
    Column("angle_deg", REAL, nullable=False),
    Column("beats", Integer, nullable=False),
)
"""The moves of the dances."""

CALIBRATION = Table(
    "calibration",
    METADATA,
    Column("robot", Text, primary_key=True),
    Column("device", Text, primary_key=True),
    Column("name", Text, primary_key=True),
    Column("value", REAL, nullable=False),
    Column("measured_at", Text, nullable=False),
    ForeignKeyConstraint(["robot", "device"], ["device.robot", "device.name"], onupdate=_CASCADE, ondelete=_CASCADE),
)
"""Numbers measured on a device."""

JOINT = Table(
    "joint",
    METADATA,
    _robot(),
    Column("name", Text, primary_key=True),
    Column("device_id", Integer, nullable=False),
    Column("side", Text, nullable=False),
    Column("sign", Integer, nullable=False),
    Column("zero_rad", REAL, nullable=False),
    Column("lower_rad", REAL, nullable=False),
    Column("upper_rad", REAL, nullable=False),
    Column("speed_rps", REAL, nullable=False),
)
"""The joints of a humanoid."""

MOTION = Table(
    "motion",
    METADATA,
    _robot(),
    Column("name", Text, primary_key=True),
    Column("help", Text, nullable=False),
    Column("lead_in", Text, nullable=False),
    Column("lead_out", Text, nullable=False),
    Column("slot", Integer),
    Column("slot_s", REAL),
    Column("limp", Integer, nullable=False),
    Column("builtin", Integer, nullable=False),
)
"""The named motions of a humanoid."""

MOTION_STEP = Table(
    "motion_step",
    METADATA,
    Column("robot", Text, primary_key=True),
    Column("motion", Text, primary_key=True),
    Column("step", Integer, primary_key=True),
    Column("duration_s", REAL, nullable=False),
    Column("positions", Text, nullable=False),
    ForeignKeyConstraint(["robot", "motion"], ["motion.robot", "motion.name"], onupdate=_CASCADE, ondelete=_CASCADE),
)
"""A key frame of a motion."""

MOTOR = Table(
    "motor",
    METADATA,
    _robot(),
    Column("layer", Text, primary_key=True),
    Column("id", Integer, primary_key=True),
    Column("name", Text, nullable=False),
    Column("description", Text, nullable=False),
    Column("initial", Integer, nullable=False),
    Column("lowest", Integer, nullable=False),
    Column("highest", Integer, nullable=False),
    Column("rest", Integer, nullable=False),
    Column("inverted", Integer, nullable=False),
    Column("builtin", Integer, nullable=False),
)
"""The servos as a face to the outside knows them."""

BUTTON = Table(
    "button",
    METADATA,
    _robot(),
    Column("id", Integer, primary_key=True),
    Column("name", Text, nullable=False),
    Column("button", Text, nullable=False),
    Column("motion", Text, nullable=False),
    Column("builtin", Integer, nullable=False),
)
"""The motions as a face to the outside knows them."""

USER_TOKEN = Table(
    "user_token",
    METADATA,
    Column("name", Text, primary_key=True),
    Column("role", Text, nullable=False),
    Column("hash", Text, nullable=False),
    Column("created_at", Text, nullable=False),
    Column("revoked_at", Text),
    Column("expires_at", Text),
    Column("good_for", Text, nullable=False),
)
"""Who may do what."""

REVISION = Table(
    "revision",
    METADATA,
    Column("id", Integer, primary_key=True),
    Column("table_name", Text, nullable=False),
    Column("row_key", Text, nullable=False),
    Column("operation", Text, nullable=False),
    Column("old_row", Text),
    Column("new_row", Text),
    Column("changed_at", Text, server_default=FetchedValue(), nullable=False),
)
"""Every change of the rows, kept by triggers."""

EVENT = Table(
    "event",
    METADATA,
    Column("id", Integer, primary_key=True),
    Column("wall_ns", Integer, nullable=False),
    Column("kind", Text, nullable=False),
    Column("subject", Text, nullable=False),
    Column("level", Text, nullable=False),
    Column("text", Text, nullable=False),
    Column("data", Text, nullable=False),
)
"""What happened."""

AUDIT = Table(
    "audit",
    METADATA,
    Column("id", Integer, primary_key=True),
    Column("wall_ns", Integer, nullable=False),
    Column("kind", Text, nullable=False),
    Column("subject", Text, nullable=False),
    Column("source", Text, nullable=False),
    Column("text", Text, nullable=False),
    Column("previous", Text, nullable=False),
    Column("hash", Text, nullable=False),
)
"""Who did what to the robot, chained by hashes."""

ADOPTED = Table(
    "adopted",
    METADATA,
    Column("revision", Integer, primary_key=True),
    Column("hash", Text, nullable=False),
    Column("wall_ns", Integer, nullable=False),
)
"""The row sets that ran."""

CONFIGURATION = (
    ROBOT,
    CAPABILITY,
    CHANNEL,
    DEVICE,
    VERB,
    EXTERNAL_COMMAND,
    PHRASE,
    CHOREOGRAPHY,
    CALIBRATION,
    JOINT,
    MOTION,
    MOTION_STEP,
    MOTOR,
    BUTTON,
)
"""The tables that make a robot; their changes are revisions."""
