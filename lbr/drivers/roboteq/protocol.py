"""The commands of a Roboteq motor controller. No I/O."""

FULL_SCALE = 1000
STOP = b"!M 0 0\r"
EMERGENCY_STOP = b"!EX\r"
ACKNOWLEDGED = b"+\r"
RELEASE = b"!MG\r"


def motors(channel1: int, channel2: int) -> bytes:
    """Return `!M`: both channels at once, each within full scale."""
    return b"!M %d %d\r" % (_checked(channel1), _checked(channel2))


def read_setting(name: str) -> bytes:
    """Return the query of a setting, such as `~RWD`."""
    return b"~%s\r" % name.encode("ascii")


def write_setting(name: str, value: int) -> bytes:
    """Return the change of a setting, such as `^RWD 200`; it is lost at the next reset."""
    return b"^%s %d\r" % (name.encode("ascii"), value)


def is_inertial_unit(identity: str) -> bool:
    """Return whether a firmware or model is that of a RIOX, which speaks the same language but drives no motor."""
    return "riox" in identity.lower()


def _checked(value: int) -> int:
    if not -FULL_SCALE <= value <= FULL_SCALE:
        raise ValueError(f"motor value {value} is outside -{FULL_SCALE}..{FULL_SCALE}")
    return value
