"""Conversion between RoboPlus motion files and motions of a robot's joints."""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from math import ceil, radians

from lbr.errors import InputError
from lbr.messages.faces import Motor
from lbr.messages.joints import MAX_FRAMES, Joint, KeyFrame, Motion
from lbr.names import LONGEST, name_from
from lbr.robot.motion_file import DIGITS, LONGEST_S, SHORTEST_S, RobotRows, sparse, split
from lbr.robot.old_data import Note, no_place
from lbr.robots.bioloid import mtn
from lbr.robots.bioloid.mtn import MtnFile, Page, Step

COUNT_RAD, MIDDLE, MOST = radians(300.0 / 1023.0), 512, 1023
"""The counts of an AX-12A, which is motor type 0."""
STEPS_OF_PAGE = 7
"""The most steps of one page in the maker's controllers."""
LONGEST_STEP_S, GRAIN_S = 2.04, 0.008
"""The longest time and the unit of time: the controllers store times in one byte, in units of 8 ms."""
TABLE = "page"


@dataclass(frozen=True, slots=True)
class MtnMotions:
    """The motions of a RoboPlus file: pages that follow one another are one motion."""

    file: MtnFile

    def fits(self, rows: RobotRows) -> bool:
        """Return whether a robot's joints match the file's servos: more than half of them, and no counts of another
        maker."""
        ids = {row.device_id for row in rows.of(Joint)}
        return len(ids & set(self.file.enabled)) * 2 > len(ids) and not rows.of(Motor)

    def motions(self, rows: RobotRows) -> tuple[tuple[Motion, ...], list[Note]]:
        """Return the motions in the angles of a robot's joints, with notes on the parts that have no place."""
        joints = {row.device_id: row for row in rows.of(Joint)}
        notes = [*_of_checksum(self.file), *_without_joint(self.file, joints)]
        usable = {
            servo: row
            for servo, row in joints.items()
            if servo in self.file.enabled and not dict(enumerate(self.file.motor_types)).get(servo)
        }
        if not usable:
            raise InputError("it moves no servo that a joint of that robot is on: name another with --robot")
        names = _names(self.file.pages, _chains(self.file.pages))
        motions = []
        for name, chain in names.items():
            page = self.file.pages[chain[0] - 1]
            if name != page.name:
                text = f"'{page.name}' is called '{name}' here; its help has the whole name"
                notes.append(Note("changed", TABLE, str(chain[0]), "name", text))
            motion, more = _motion(name, chain, self.file, usable)
            notes += more
            if motion.frames:
                motions.append(motion)
        empty = [str(number) for number, page in enumerate(self.file.pages, 1) if not page.steps]
        if empty:
            notes.append(no_place(TABLE, ", ".join(empty), "step", "a page without steps is no motion"))
        if not motions:
            raise InputError("none of its pages has a step")
        return tuple(motions), notes


def read(content: bytes) -> MtnMotions:
    """Return the motions in a file; raise InputError naming an invalid line."""
    return MtnMotions(mtn.parse(content))


def write(motion: Motion, rows: RobotRows) -> tuple[bytes, list[Note]]:
    """Return a motion as a RoboPlus file, with notes on its losses; raise InputError for a servo that the file cannot
    have."""
    joints = {row.name: row for row in rows.of(Joint)}
    used = {name for frame in motion.frames for name in frame.positions}
    for name in sorted(used):
        if name not in joints:
            raise InputError(f"there is no joint '{name}'", "unknown_name")
        if joints[name].device_id >= mtn.SERVOS:
            raise InputError(
                f"joint '{name}' is on servo {joints[name].device_id}, and a file has 0 to {mtn.SERVOS - 1}"
            )
    notes: list[Note] = []
    at = [MIDDLE] * mtn.SERVOS
    for frame in reversed(motion.frames):
        for name, angle in frame.positions.items():
            at[joints[name].device_id] = _count(joints[name], angle)
    later = sorted(used - set(motion.frames[0].positions)) if motion.frames else []
    if later:
        text = f"a page names all servos in every step: {', '.join(later)} begin at their first position"
        notes.append(Note("changed", "motion", motion.name, "positions", text))
    steps = []
    for frame in split(motion.frames, LONGEST_STEP_S):
        for name, angle in frame.positions.items():
            at[joints[name].device_id] = _count(joints[name], angle)
        steps.append(Step(tuple(at), 0.0, max(1, round(frame.duration_s / GRAIN_S)) * GRAIN_S))
    pages = ceil(len(steps) / STEPS_OF_PAGE)
    if pages > mtn.MOST_PAGES:
        raise InputError(f"'{motion.name}' would take {pages} pages, and a file has {mtn.MOST_PAGES}")
    parts = [steps[index : index + STEPS_OF_PAGE] for index in range(0, len(steps), STEPS_OF_PAGE)]
    file = MtnFile(
        tuple(
            Page(
                motion.name if number == 1 else f"{motion.name} {number}",
                tuple(part),
                next=number + 1 if number < len(parts) else 0,
            )
            for number, part in enumerate(parts, 1)
        ),
        tuple(sorted(joints[name].device_id for name in used)),
    )
    return mtn.write(file), notes


def _count(row: Joint, angle: float) -> int:
    return min(MOST, max(0, MIDDLE + round((row.zero_rad + row.sign * angle) / COUNT_RAD)))


def _angle(row: Joint, count: int) -> float:
    return round(row.sign * ((count - MIDDLE) * COUNT_RAD - row.zero_rad), DIGITS) + 0.0


def _of_checksum(file: MtnFile) -> Iterator[Note]:
    text = {
        "stale": "it is of other lines: the file was changed by another program than RoboPlus, and is taken as it is",
        "missing": "the file ends without it: it may have been cut off after a page, and is taken as it is",
    }.get(file.checksum)
    if text is not None:
        yield no_place("file", "", "checksum", text)


def _without_joint(file: MtnFile, joints: dict[int, Joint]) -> Iterator[Note]:
    types = dict(enumerate(file.motor_types))
    for servo in file.enabled:
        if servo not in joints:
            yield no_place("enable", str(servo), "", "no joint of this robot is on that servo")
        elif types.get(servo):
            text = f"it is of motor type {types[servo]}, whose counts are not known here: its joint stays where it is"
            yield no_place("motor_type", str(servo), "", text)


def _chains(pages: tuple[Page, ...]) -> list[list[int]]:
    """Return for each motion the numbers of its pages, in the order of play."""
    with_steps = [number for number, page in enumerate(pages, 1) if page.steps]
    led_to = {page.next for number, page in enumerate(pages, 1) if page.next != number}
    chains: list[list[int]] = []
    for number in [*(one for one in with_steps if one not in led_to), *with_steps]:
        if any(number in chain for chain in chains):
            continue
        chain = [number]
        while 1 <= (after := pages[chain[-1] - 1].next) <= len(pages) and after not in chain and pages[after - 1].steps:
            chain.append(after)
        chains.append(chain)
    return chains


def _names(pages: tuple[Page, ...], chains: list[list[int]]) -> dict[str, list[int]]:
    """Return the chains by the names of their motions: the name of the first page, with a number if it is taken."""
    plain = {chain[0]: name_from(pages[chain[0] - 1].name, "motion") for chain in chains}
    all_names = set(plain.values())
    by_name: dict[str, list[int]] = {}
    for chain in chains:
        name, number = plain[chain[0]], 1
        while name in by_name or (number > 1 and name in all_names):
            number += 1
            name = f"{plain[chain[0]][: LONGEST - 4]}_{number}"
        by_name[name] = chain
    return by_name


def _motion(name: str, chain: list[int], file: MtnFile, joints: dict[int, Joint]) -> tuple[Motion, list[Note]]:
    pages = [(number, file.pages[number - 1]) for number in chain]
    notes: list[Note] = []
    frames: list[KeyFrame] = []
    beyond: list[int] = []
    for number, page in pages:
        row = f"{number} ({page.name})" if page.name else str(number)
        times = page.times if page.times >= 1 and len(frames) + page.times * len(page.steps) * 2 <= MAX_FRAMES else 1
        if times != page.times:
            text = "played several times there, once here: /play/NAME/N plays the motion N times"
            notes.append(no_place(TABLE, row, "play_param.times", text))
        for _ in range(times):
            frames += _frames(page, joints, beyond)
        follows = [*chain, 0][chain.index(number) + 1]
        notes += _unplayed(row, page, chain, follows)
    if beyond:
        lines = ", ".join(map(str, sorted(set(beyond))[:5]))
        text = f"line {lines}: positions above {MOST} do not exist on such a servo; its joint stays there"
        notes.append(no_place(TABLE, str(chain[0]), "step", text))
    return Motion(name=name, frames=tuple(sparse(split(frames, LONGEST_S))), help=pages[0][1].name[:200]), notes


def _frames(page: Page, joints: dict[int, Joint], beyond: list[int]) -> Iterable[KeyFrame]:
    for step in page.steps:
        positions = {
            row.name: _angle(row, step.positions[servo])
            for servo, row in joints.items()
            if servo < len(step.positions) and step.positions[servo] <= MOST
        }
        if any(step.positions[servo] > MOST for servo in joints if servo < len(step.positions)):
            beyond.append(step.line)
        yield KeyFrame(positions=positions, duration_s=max(SHORTEST_S, step.time_s / page.speed))
        if step.pause_s > 0.0:
            yield KeyFrame(positions=positions, duration_s=max(SHORTEST_S, step.pause_s / page.speed))


def _unplayed(row: str, page: Page, chain: list[int], follows: int) -> Iterator[Note]:
    """Yield a note for each feature of a page that a motion here lacks."""
    if page.speed != 1.0:
        text = f"times are divided by the page's speed, {page.speed:g}"
        yield Note("changed", TABLE, row, "play_param.speed", text)
    if page.next != follows:
        back = "it leads back to a page before: /play/NAME/N plays the motion N times"
        text = back if page.next in chain else "it leads to a page that is not a motion: it ends here"
        yield no_place(TABLE, row, "play_param.next", text)
    if page.exit:
        text = "another page would follow a stop; here the joints hold at once"
        yield no_place(TABLE, row, "play_param.exit", text)
    if page.inertia not in {0, 32}:
        yield no_place(TABLE, row, "play_param.inertia", "the joints here have their own way of speeding up")
    if set(page.compliance) - {5}:
        yield no_place(TABLE, row, "compliance", "how soft a servo is, is a setting of the driver, not of a motion")
