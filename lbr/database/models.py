"""Every table as a SQLAlchemy model; robot.db.sql builds them, and a test keeps the two the same."""

from sqlalchemy import REAL, FetchedValue, ForeignKey, ForeignKeyConstraint, Integer, Text
from sqlalchemy.orm import DeclarativeBase, Mapped, mapped_column

_ROBOT = "robot.name"
_CASCADE = "CASCADE"


class Model(DeclarativeBase):
    """A table; flags are 0 or 1 and JSON is text, so that a bad row can be read and named."""

    type_annotation_map = {str: Text, int: Integer, float: REAL}  # noqa: RUF012 - SQLAlchemy reads this attribute


def _robot_key() -> Mapped[str]:
    return mapped_column(ForeignKey(_ROBOT, onupdate=_CASCADE, ondelete=_CASCADE), primary_key=True)


class Robot(Model):
    """The robots that the file describes."""

    __tablename__ = "robot"
    name: Mapped[str] = mapped_column(primary_key=True)
    model: Mapped[str]
    description: Mapped[str]
    owner: Mapped[str]
    last_start: Mapped[str | None]
    last_shutdown: Mapped[str | None]
    estop_engaged: Mapped[int]
    estop_reason: Mapped[str]


class Capability(Model):
    """What runs."""

    __tablename__ = "capability"
    robot: Mapped[str] = _robot_key()
    name: Mapped[str] = mapped_column(primary_key=True)
    kind: Mapped[str]
    enabled: Mapped[int]
    settings: Mapped[str]
    restart: Mapped[str]
    needs: Mapped[str]
    help: Mapped[str]


class Channel(Model):
    """Which output feeds which input."""

    __tablename__ = "channel"
    robot: Mapped[str] = _robot_key()
    source: Mapped[str] = mapped_column(primary_key=True)
    target: Mapped[str] = mapped_column(primary_key=True)
    rate_hz: Mapped[float | None]
    history: Mapped[int]
    enabled: Mapped[int]


class Device(Model):
    """What is plugged in."""

    __tablename__ = "device"
    robot: Mapped[str] = _robot_key()
    name: Mapped[str] = mapped_column(primary_key=True)
    type: Mapped[str]
    address: Mapped[str]
    settings: Mapped[str]


class Verb(Model):
    """The console's vocabulary."""

    __tablename__ = "verb"
    robot: Mapped[str] = _robot_key()
    word: Mapped[str] = mapped_column(primary_key=True)
    pattern: Mapped[str] = mapped_column(primary_key=True)
    target: Mapped[str]
    payload: Mapped[str | None]
    role: Mapped[str]
    help: Mapped[str]


class ExternalCommand(Model):
    """Programs started by name."""

    __tablename__ = "external_command"
    robot: Mapped[str] = _robot_key()
    name: Mapped[str] = mapped_column(primary_key=True)
    argv: Mapped[str]
    blocking: Mapped[int]
    enabled: Mapped[int]
    help: Mapped[str]


class Phrase(Model):
    """What the robots say."""

    __tablename__ = "phrase"
    name: Mapped[str] = mapped_column(primary_key=True)
    language: Mapped[str] = mapped_column(primary_key=True)
    text: Mapped[str]


class Choreography(Model):
    """The moves of the dances."""

    __tablename__ = "choreography"
    robot: Mapped[str] = _robot_key()
    dance: Mapped[str] = mapped_column(primary_key=True)
    step: Mapped[int] = mapped_column(primary_key=True)
    power: Mapped[float]
    angle_deg: Mapped[float]
    beats: Mapped[int]


class Calibration(Model):
    """Numbers measured on a device."""

    __tablename__ = "calibration"
    __table_args__ = (
        ForeignKeyConstraint(
            ["robot", "device"], ["device.robot", "device.name"], onupdate=_CASCADE, ondelete=_CASCADE
        ),
    )
    robot: Mapped[str] = mapped_column(primary_key=True)
    device: Mapped[str] = mapped_column(primary_key=True)
    name: Mapped[str] = mapped_column(primary_key=True)
    value: Mapped[float]
    measured_at: Mapped[str]


class Joint(Model):
    """The joints of a humanoid."""

    __tablename__ = "joint"
    robot: Mapped[str] = _robot_key()
    name: Mapped[str] = mapped_column(primary_key=True)
    device_id: Mapped[int]
    side: Mapped[str]
    sign: Mapped[int]
    zero_rad: Mapped[float]
    lower_rad: Mapped[float]
    upper_rad: Mapped[float]
    speed_rps: Mapped[float]


class Motion(Model):
    """The named motions of a humanoid."""

    __tablename__ = "motion"
    robot: Mapped[str] = _robot_key()
    name: Mapped[str] = mapped_column(primary_key=True)
    help: Mapped[str]
    lead_in: Mapped[str]
    lead_out: Mapped[str]
    slot: Mapped[int | None]
    slot_s: Mapped[float | None]
    limp: Mapped[int]
    builtin: Mapped[int]


class MotionStep(Model):
    """A key frame of a motion."""

    __tablename__ = "motion_step"
    __table_args__ = (
        ForeignKeyConstraint(
            ["robot", "motion"], ["motion.robot", "motion.name"], onupdate=_CASCADE, ondelete=_CASCADE
        ),
    )
    robot: Mapped[str] = mapped_column(primary_key=True)
    motion: Mapped[str] = mapped_column(primary_key=True)
    step: Mapped[int] = mapped_column(primary_key=True)
    duration_s: Mapped[float]
    positions: Mapped[str]


class Motor(Model):
    """The servos as a face to the outside knows them."""

    __tablename__ = "motor"
    robot: Mapped[str] = _robot_key()
    layer: Mapped[str] = mapped_column(primary_key=True)
    id: Mapped[int] = mapped_column(primary_key=True)
    name: Mapped[str]
    description: Mapped[str]
    initial: Mapped[int]
    lowest: Mapped[int]
    highest: Mapped[int]
    rest: Mapped[int]
    inverted: Mapped[int]
    builtin: Mapped[int]


class Button(Model):
    """The motions as a face to the outside knows them."""

    __tablename__ = "button"
    robot: Mapped[str] = _robot_key()
    id: Mapped[int] = mapped_column(primary_key=True)
    name: Mapped[str]
    button: Mapped[str]
    motion: Mapped[str]
    builtin: Mapped[int]


class UserToken(Model):
    """Who may do what."""

    __tablename__ = "user_token"
    name: Mapped[str] = mapped_column(primary_key=True)
    role: Mapped[str]
    hash: Mapped[str]
    created_at: Mapped[str]
    revoked_at: Mapped[str | None]
    expires_at: Mapped[str | None]


class Revision(Model):
    """Every change of the rows, kept by triggers."""

    __tablename__ = "revision"
    id: Mapped[int] = mapped_column(primary_key=True)
    table_name: Mapped[str]
    row_key: Mapped[str]
    operation: Mapped[str]
    old_row: Mapped[str | None]
    new_row: Mapped[str | None]
    changed_at: Mapped[str] = mapped_column(server_default=FetchedValue())


class StoredEvent(Model):
    """What happened."""

    __tablename__ = "event"
    id: Mapped[int] = mapped_column(primary_key=True)
    wall_ns: Mapped[int]
    kind: Mapped[str]
    subject: Mapped[str]
    level: Mapped[str]
    text: Mapped[str]
    data: Mapped[str]


class AuditEntry(Model):
    """Who did what to the robot, chained by hashes."""

    __tablename__ = "audit"
    id: Mapped[int] = mapped_column(primary_key=True)
    wall_ns: Mapped[int]
    kind: Mapped[str]
    subject: Mapped[str]
    source: Mapped[str]
    text: Mapped[str]
    previous: Mapped[str]
    hash: Mapped[str]


class Adopted(Model):
    """The row sets that ran."""

    __tablename__ = "adopted"
    revision: Mapped[int] = mapped_column(primary_key=True)
    hash: Mapped[str]
    wall_ns: Mapped[int]


CONFIGURATION: tuple[type[Model], ...] = (
    Robot,
    Capability,
    Channel,
    Device,
    Verb,
    ExternalCommand,
    Phrase,
    Choreography,
    Calibration,
    Joint,
    Motion,
    MotionStep,
    Motor,
    Button,
)
"""The tables that make a robot; their changes are revisions."""
