"""The joints of the rows: their servos' angles, their limits, and their partners in a mirror."""

from collections.abc import Mapping
from math import degrees, isfinite

from msgspec import Struct

from lbr.messages.codes import Reason
from lbr.messages.joints import Joint
from lbr.names import did_you_mean

TURNING_OVER = ("_yaw", "_roll")
"""The names of joints that turn about x or z: in a mirror they turn the other way, even in the middle of the body."""
LONGEST_NAME = 40


class Body(Struct, frozen=True):
    """All joints, by name."""

    joints: Mapping[str, Joint]

    def servo_rad(self, name: str, joint_rad: float) -> float:
        """Return the angle of the servo at an angle of its joint."""
        joint = self.joints[name]
        return joint.zero_rad + joint.sign * joint_rad

    def joint_rad(self, name: str, servo_rad: float) -> float:
        """Return the angle of a joint at an angle of its servo."""
        joint = self.joints[name]
        return (servo_rad - joint.zero_rad) * joint.sign

    def within(self, name: str, joint_rad: float) -> float:
        """Return the angle, limited to the joint's range."""
        joint = self.joints[name]
        return min(max(joint_rad, joint.lower_rad), joint.upper_rad)

    def beyond_rad(self, name: str, joint_rad: float) -> float:
        """Return the distance of an angle beyond the limits of its joint; 0 within them."""
        return abs(joint_rad - self.within(name, joint_rad))

    def refusal(self, name: str, joint_rad: float) -> Reason | None:
        """Return why a joint cannot have an angle, or None."""
        if why := self.unknown(name):
            return why
        if not isfinite(joint_rad):
            return Reason("bad_value", f"{name} is to go to {joint_rad}, which is not an angle")
        joint = self.joints[name]
        if joint.lower_rad <= joint_rad <= joint.upper_rad:
            return None
        lower_deg, upper_deg = degrees(joint.lower_rad), degrees(joint.upper_rad)
        limits = f"{joint.lower_rad:g} to {joint.upper_rad:g} rad, {lower_deg:.0f} to {upper_deg:.0f} degrees"
        outside = f"{name} {joint_rad:g} rad ({degrees(joint_rad):.0f} degrees) is outside its limits ({limits})"
        return Reason("limit", outside)

    def unknown(self, name: str) -> Reason | None:
        """Return that there is no such joint, with a suggestion; or None."""
        if name in self.joints:
            return None
        shown = name[:LONGEST_NAME]
        return Reason("unknown_name", f"there is no joint {shown!r}; {did_you_mean(shown, self.joints)}")

    def partner(self, name: str) -> str:
        """Return the joint's partner in a mirror, or an empty string."""
        side = self.joints[name].side
        if side == "centre":
            return name
        other = "right" if side == "left" else "left"
        partner = name.replace(side, other)
        mirror_joint = self.joints.get(partner)
        return partner if mirror_joint is not None and mirror_joint.side == other else ""

    def mirrored(self, positions: Mapping[str, float]) -> dict[str, float]:
        """Return a pose in a mirror; every joint of it must be known and have a partner."""
        return {self.partner(name): self._turned_over(name, angle) for name, angle in positions.items()}

    def _turned_over(self, name: str, joint_rad: float) -> float:
        centre = self.joints[name].side == "centre"
        return -joint_rad if centre and name.endswith(TURNING_OVER) else joint_rad


def body(joints: tuple[Joint, ...]) -> Body:
    """Return the joints of the rows."""
    return Body({joint.name: joint for joint in joints})
