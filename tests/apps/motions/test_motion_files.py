"""Motion files: the maker's and our own become motions within the joints' limits, or a sentence says why not."""

import contextlib
from math import degrees, radians

import pytest
from hypothesis import given
from hypothesis import strategies as st
from msgspec.structs import replace

from lbr.apps.motions.commands import motion_files
from lbr.database.checks import check
from lbr.errors import InputError
from lbr.messages.joints import Joint, KeyFrame, Motion, MotionStep
from lbr.robot.motion_file import LARGEST_BYTES
from lbr.robots.uxa90 import motion_file, rbm
from tests.support import databases

STAND = (127, 127, 127, 127, 48, 206, 127, 127, 127, 127, 127, 127, 80, 174, 137, 117, 127, 127, 206, 48, 127, 127, 127, 127, 127)  # fmt: skip
HEADER = ["1", "13", "6012000010005", "someone", "a@b.c", "7", "A: test", "0", "4"]


def content(*scenes: tuple[int, int, dict[int, int]], ends: str = "\n") -> bytes:
    """Return a file: scenes of this many frames and milliseconds to these positions, from standing upright."""
    at = dict(enumerate((*STAND, 0)))
    fields = [*HEADER, str(len(scenes)), "2", "26", "0"]
    for servo, zero in at.items():
        fields += [str(servo), "20", "30", "0", "0", str(zero)]
    for index, (frames, transition_ms, moves) in enumerate(scenes):
        fields += [str(index), "5", "Scene", str(frames), str(transition_ms)]
        for servo, start in at.items():
            fields += ["0", str(servo), str(start), str(moves.get(servo, start)), "2", "0"]
        at |= moves
    return ":".join(fields).encode() + ends.encode()


NOD = content((20, 400, {24: 150, 23: 100}), (10, 300, {24: 127}), ends=":\r\n")


@pytest.fixture(scope="module")
def rows():
    return databases.of_robot("uxa90")


def test_a_file_is_read_field_by_field(rows):
    found = rbm.parse(NOD)
    assert (found.name, found.serial, found.author) == ("A: test", "6012000010005", "someone")
    assert found.zeros[5] == 206
    assert [(scene.frames, scene.transition_s) for scene in found.scenes] == [(20, 0.4), (10, 0.3)]
    assert found.scenes[1].moves[24] == (24, 150, 127, 2)


def test_nominal_counts_become_angles_of_the_joints_whatever_the_robots_own_zeros_are(rows):
    raw, columns = databases.tables()
    other = {**raw, "joint": [{**row, "zero_rad": row["zero_rad"] + 0.1} for row in raw["joint"]]}
    moved = check(other, "uxa90", columns=columns)
    for known in (rows, moved):
        motion, notes = motion_file.of_rbm(rbm.parse(NOD), known)
        assert [(note.kind, note.column) for note in notes] == [("no_place", "gains, torque")]
        assert motion.name == "a_test"
        stand, first, second = motion.frames
        assert len(stand.positions) == 25
        assert set(stand.positions.values()) == {0.0}
        assert first.duration_s == 0.4
        assert first.positions == {
            "head_pitch": pytest.approx(radians(23 * 269 / 254), abs=1e-4),
            "neck_yaw": pytest.approx(radians(27 * 269 / 254), abs=1e-4),  # it counts the other way
        }
        assert (second.duration_s, second.positions) == (0.3, {"head_pitch": 0.0})


def test_the_walking_stance_is_the_one_that_the_rows_have(rows):
    stance = (125, 127, 102, 150, 89, 166, 146, 109, 127, 127, 127, 127, 63, 191, 137, 117, 131, 123, 174, 80, 127, 127, 127, 127, 127)  # fmt: skip
    motion, _ = motion_file.of_rbm(rbm.parse(content((10, 400, dict(enumerate(stance))))), rows)
    (shipped,) = [step.positions for step in rows.of(MotionStep) if step.motion == "basic_motion"]
    assert motion.frames[0].positions | motion.frames[1].positions == pytest.approx(shipped, abs=1e-3)


def test_a_stretch_of_more_than_a_minute_is_split_on_a_straight_line(rows):
    motion, _ = motion_file.of_rbm(rbm.parse(content((10, 90_000, {24: 147}))), rows)
    assert [frame.duration_s for frame in motion.frames] == [1.0, 45.0, 45.0]
    half, whole = (frame.positions["head_pitch"] for frame in motion.frames[1:])
    assert half == pytest.approx(whole / 2, abs=1e-4)


def test_scenes_that_do_not_chain_and_other_zeros_are_told(rows, wording):
    broken = (
        NOD.decode().replace(":0:24:150:127:2:0", ":0:24:140:127:2:0").replace(":5:20:30:0:0:206", ":5:20:30:0:0:200")
    )
    motion, notes = motion_file.of_rbm(rbm.parse(broken.encode()), rows)
    assert len(motion.frames) == 4
    assert "servo 5 (200, not 206)" in notes[0].text
    wording(notes[1].text)


@pytest.mark.parametrize(
    "change",
    [
        (b":26:0:", b":99:0:"),
        (b":20:400:", b":20:-4:"),
        (b":127:150:", b":127:256:"),
        (b":127:150:", b":127:x\x1b:"),
        (b":150:127:2:0", b""),
        (b":0:25:0:0:2:0", b":0:24:0:0:2:0"),
    ],
)
def test_a_field_that_cannot_be_is_named(change, wording):
    with wording.of(InputError):
        rbm.parse(NOD.replace(*change))


def test_what_follows_the_last_scene_is_told(wording):
    with wording.of(InputError):
        rbm.parse(NOD.strip() + b"5:6")


@given(st.binary(max_size=300))
def test_bytes_by_chance_are_a_file_or_a_sentence(found):
    with pytest.raises(InputError):
        motion_files.read(found)
    with pytest.raises(InputError):
        motion_files.read(found, ".rbm")


@given(st.integers(0, len(NOD) - 1), st.binary(max_size=6), st.integers(0, 12))
def test_a_damaged_file_is_a_file_or_a_sentence(at, put, cut):
    with contextlib.suppress(InputError):
        assert rbm.parse(NOD[:at] + put + NOD[at + cut :]).scenes


def nod(angle: float) -> Motion:
    return Motion(name="nod", frames=(KeyFrame(positions={"head_pitch": angle}, duration_s=1.0),))


def test_joints_beyond_their_limits_are_named_or_clipped(rows):
    with pytest.raises(InputError, match=r"head_pitch: 2.000 is outside -0.832 to 0.925\. --clip"):
        motion_files.within_limits(nod(2.0), rows.of(Joint), clip=False)
    clipped, count = motion_files.within_limits(nod(2.0), rows.of(Joint), clip=True)
    assert (clipped.frames[0].positions, count) == ({"head_pitch": 0.925}, 1)
    tail = replace(nod(0.0), frames=(KeyFrame(positions={"tail": 0.0}, duration_s=1.0),))
    with pytest.raises(InputError, match="there is no joint 'tail' here"):
        motion_files.within_limits(tail, rows.of(Joint), clip=True)


def test_the_fastest_joint_is_the_one_nearest_its_limit(rows):
    motion, _ = motion_file.of_rbm(rbm.parse(NOD), rows)
    about = motion_files.summary(motion, rows.of(Joint))
    assert (about.frames, about.duration_s, about.joints) == (3, 1.7, 25)
    assert about.fastest == "head_pitch"
    assert degrees(about.speed_rps) == pytest.approx(23 * 269 / 254 / 0.3, rel=1e-3)
    assert about.limit_rps == 3.0


def test_what_was_exported_is_read_back(rows):
    motion = replace(nod(0.5), help="Nods", lead_in="ready")
    written, notes = motion_files.exported("uxa90", motion, rows)
    found = motion_files.read(written)
    assert notes == []
    assert (found.robot, found.motion) == ("uxa90", motion)
    with pytest.raises(InputError, match="kept by the robot's controller, in slot 4"):
        motion_files.exported("uxa90", replace(motion, slot=4), rows)


@pytest.mark.parametrize(
    ("content", "why"),
    [
        (b"{}", "it is not a motion"),
        (
            b'{"format": "lbr-motion", "robot": "uxa90", "motion": {"name": "a", "frames": [{"positions": {}}]}}',
            "duration_s",
        ),
        (b'{"format": "lbr-motion", "robot": "uxa90", "more": 1}', "more"),
        (b"{" * 5000, "it is not a motion"),
        (b'{"format": "lbr-motion", "robot": "\xff"}', "it is not a motion"),
        (b"{" + b" " * LARGEST_BYTES, "bytes"),
    ],
)
def test_json_that_is_no_motion_is_refused_with_the_reason(content, why):
    with pytest.raises(InputError, match=why):
        motion_files.read(content)


def written(motion, rows):
    data, notes = motion_file.write(motion, rows)
    found = rbm.parse(data)
    back, _ = motion_file.of_rbm(found, rows)
    return found, back, [str(note) for note in notes]


def poses(motion):
    at, found = {}, []
    for frame in motion.frames:
        at = {**at, **frame.positions}
        found.append(at)
    return found


JOINTS = ("head_pitch", "neck_yaw", "left_elbow", "right_knee", "right_shoulder_pitch", "left_hip_roll")
ANGLES = st.dictionaries(st.sampled_from(JOINTS), st.floats(-0.9, 0.9, allow_nan=False), min_size=1)
FRAMES = st.lists(
    st.builds(KeyFrame, positions=ANGLES, duration_s=st.integers(10, 60_000).map(lambda ms: ms / 1000)),
    min_size=1,
    max_size=6,
)


@given(FRAMES)
def test_a_motion_that_is_written_comes_back_as_exact_as_its_counts(rows, drawn):
    motion = Motion(name="bow", frames=tuple(drawn))
    _, back, _ = written(motion, rows)
    assert back.name == "bow"
    wanted, found = poses(motion), poses(back)
    assert len(found) == max(2, len(wanted))
    for want, pose in zip(wanted, found, strict=False):
        assert all(abs(pose[name] - angle) <= motion_file.COUNT_RAD / 2 + 1e-3 for name, angle in want.items())
    durations = [round(frame.duration_s, 3) for frame in drawn][-len(back.frames) + 1 :]
    assert [round(frame.duration_s, 3) for frame in back.frames[1:]] == durations


def test_what_a_makers_file_cannot_say_is_told(rows):
    frame = KeyFrame(positions={"head_pitch": 0.3}, duration_s=2.0)
    far = KeyFrame(positions={"left_elbow": -9.0}, duration_s=1.0)
    found, _, notes = written(Motion(name="nod", frames=(frame, far), lead_in="bow"), rows)
    assert found.name == "nod"
    assert ["gains" in note or "names all servos" in note for note in notes[:2]] == [True, True]
    assert "the 2 s to get there" in notes[2]
    assert "left_elbow would go beyond" in notes[3]
    assert "lead_in" in notes[4]


def test_a_joint_that_such_a_file_does_not_know_is_named(rows):
    tail = Motion(name="wag", frames=(KeyFrame(positions={"tail": 0.3}, duration_s=1.0),))
    with pytest.raises(InputError, match="'tail' has no motor"):
        motion_file.write(tail, rows)
