"""RoboPlus motion files: what is written is read again, what is damaged gives a sentence with its line."""

import contextlib
from math import radians
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from lbr.apps.motions.commands import motion_files
from lbr.errors import InputError
from lbr.messages.joints import KeyFrame, Motion
from lbr.robots.bioloid import motion_file, mtn
from lbr.robots.bioloid.mtn import MtnFile, Page, Step
from tests.support import databases
from tests.support.old_data import BOW, ENABLED, step
from tests.support.old_data import motion_file as content

ROBOPLUS = Path(__file__).with_name("roboplus")
NAMES = st.text(st.characters(exclude_categories=("C", "Z")), max_size=12)
SECONDS = st.integers(0, 60_000).map(lambda ms: ms / 1000)


@st.composite
def files(draw):
    width = draw(st.integers(1, 30))
    counts = st.tuples(*[st.integers(0, mtn.MOST_COUNTS)] * width)
    steps = st.lists(st.builds(Step, counts, SECONDS, SECONDS, st.just(0)), max_size=4).map(tuple)
    small = st.integers(0, 300)
    pages = st.builds(
        Page,
        name=NAMES,
        steps=steps,
        compliance=st.tuples(*[st.integers(0, 9)] * width),
        next=small,
        exit=small,
        times=small,
        speed=st.integers(1, 9000).map(lambda n: n / 1000),
        inertia=small,
    )
    found = draw(st.lists(pages, min_size=1, max_size=5))
    enabled = draw(st.sets(st.integers(0, width - 1)))
    return width, MtnFile(tuple(found), tuple(sorted(enabled)), (0,) * width)


def plain(file: MtnFile) -> MtnFile:
    return file._replace(
        pages=tuple(page._replace(steps=tuple(one._replace(line=0) for one in page.steps)) for page in file.pages)
    )


@pytest.fixture(scope="module")
def rows():
    return {name: databases.of_robot(name) for name in ("bioloid", "lbr", "uxa90")}


@given(files())
def test_what_is_written_is_read_again(drawn):
    width, file = drawn
    if not any(page.steps for page in file.pages):
        file = file._replace(pages=(file.pages[0]._replace(steps=(Step((0,) * width, 0.0, 1.0),)), *file.pages[1:]))
    assert plain(mtn.parse(mtn.write(file))) == file


@given(st.binary(max_size=300))
def test_bytes_by_chance_are_a_sentence(found):
    with pytest.raises(InputError):
        mtn.parse(found)


WHOLE = content(Page("Bow", BOW), Page("Walk", BOW, next=1))


@given(st.integers(0, len(WHOLE) - 1), st.binary(max_size=6), st.integers(0, 12))
def test_a_damaged_file_is_a_file_or_a_sentence_with_its_line(at, put, cut):
    try:
        mtn.parse(WHOLE[:at] + put + WHOLE[at + cut :])
    except InputError as err:
        assert str(err).startswith("line ")  # noqa: PT017


@given(st.integers(0, WHOLE.rindex(b"page_end")))
def test_a_truncated_file_is_told(at):
    with contextlib.suppress(InputError):
        assert len(mtn.parse(WHOLE[:at]).pages) == 1  # cut between its pages: nothing shows that there were two


@pytest.mark.parametrize(
    "change",
    [
        (b"type=motion\n", b""),
        (b"page_end", b""),
        (b"play_param=0 0 1 1.000 32", b"play_param=0 0 1 0.000 32"),
        (b"play_param=0 0 1 1.000 32", b"play_param=0 0 1"),
        (b"step=0 235", b"step=235"),
        (b"step=0 235", b"step=0 -35"),
        (b"0.000 1.000\n", b"0.000 NaN\n"),
        (b"version=1.01", b"colour=red"),
        (b"enable=0", b"enable=x"),
    ],
)
def test_a_line_that_cannot_be_is_named(change, wording):
    with wording.of(InputError):
        mtn.parse(WHOLE.replace(*change, 1))


def test_names_are_read_in_the_encodings_that_such_files_have():
    named = "인사"
    for encoded in (named.encode(), named.encode("cp949")):
        found = mtn.parse(WHOLE.replace(b"name=Bow", b"name=" + encoded))
        assert found.pages[0].name == named
    assert mtn.parse(WHOLE.removeprefix(mtn.BOM)).pages[0].name == "Bow"
    assert mtn.parse(WHOLE[:-2].decode("utf-8-sig").encode("utf-16")).pages[1].name == "Walk"
    assert mtn.parse(WHOLE.replace(b"name=Bow", b"name=B\x1b[2Jw")).pages[0].name == "B?[2Jw"
    assert mtn.parse(WHOLE + b"\0\xff").pages == mtn.parse(WHOLE).pages


@pytest.mark.parametrize(
    ("name", "checksum"),
    [("sound", "right"), ("escaped", "right"), ("stale", "stale"), ("no", "missing")],
)
def test_a_checksum_is_compared_and_never_refused(name, checksum, rows):
    found = mtn.parse((ROBOPLUS / f"{name}_checksum.mtn").read_bytes())
    assert (len(found.pages), found.checksum) == (1, checksum)
    _, notes = motion_file.MtnMotions(found).motions(rows["bioloid"])
    assert ("checksum" in {note.column for note in notes}) == (checksum != "right")


def test_a_file_is_written_to_the_byte_as_its_maker_does():
    sound = (ROBOPLUS / "sound_checksum.mtn").read_bytes()
    assert mtn.write(mtn.parse(sound)) == sound


@given(st.sampled_from([b"\r", b"\r\n", b"\n"]), st.binary(max_size=2))
def test_lines_end_as_any_editor_ends_them_and_a_checksum_is_any_bytes(line_end, end):
    found = mtn.parse(WHOLE[:-2].replace(b"\n", line_end) + end)
    assert found.pages == mtn.parse(WHOLE).pages
    assert (found.checksum == "right") == (end == WHOLE[-2:])


def test_an_editors_file_with_old_line_ends_is_read():
    assert len(mtn.parse((ROBOPLUS / "cr_line_ends.mtn").read_bytes()).pages) == 1


def test_counts_become_angles_of_joints_and_a_pause_a_frame_of_its_own(rows):
    (bow,), notes = motion_file.read(content(Page("Bow", BOW))).motions(rows["bioloid"])
    assert (bow.name, [frame.duration_s for frame in bow.frames]) == ("bow", [1.0, 0.6, 0.2, 0.6])
    hip = [frame.positions.get("right_hip_pitch") for frame in bow.frames]
    assert hip[0] == pytest.approx(radians((512 - 341) * 300 / 1023), abs=1e-3)
    assert hip[1] == pytest.approx(radians((512 - 300) * 300 / 1023), abs=1e-3)
    assert bow.frames[2].positions == {}
    assert set(bow.frames[1].positions) == {"right_hip_pitch", "left_hip_pitch"}
    assert [note.column for note in notes] == ["name"]


def test_pages_that_lead_to_each_other_are_one_motion_and_what_has_no_place_is_told(rows):
    pages = (
        Page("Dance", BOW[:1], next=2, times=2, speed=2.0),
        Page("Dance 2", BOW[1:], exit=3, compliance=(5, 7)),
        Page("Round", BOW, next=3),
        Page("Nowhere", BOW, next=99),
        Page("", ()),
        Page("Bow", BOW, times=255),
    )
    found, notes = motion_file.read(content(*pages)).motions(rows["bioloid"])
    assert [(one.name, len(one.frames)) for one in found] == [("dance", 5), ("round", 4), ("nowhere", 4), ("bow", 4)]
    assert found[0].frames[0].duration_s == 0.5
    told = {(note.row.partition(" ")[0], note.column) for note in notes if note.kind == "no_place"}
    assert told == {
        ("2", "play_param.exit"), ("2", "compliance"), ("3", "play_param.next"), ("4", "play_param.next"),
        ("5", "step"), ("6", "play_param.times"),
    }  # fmt: skip


@pytest.mark.parametrize(
    ("called", "names"),
    [
        (("Bow 2", "Bow", "Bow"), ["bow_2", "bow", "bow_3"]),
        (("Bow", "Bow", "Bow 2"), ["bow", "bow_3", "bow_2"]),
        (("Bow", "bow!", "BOW"), ["bow", "bow_2", "bow_3"]),
        (("b" * 50, "b" * 45), ["b" * 40, "b" * 36 + "_2"]),
    ],
)
def test_no_two_motions_of_a_file_have_one_name(rows, called, names):
    found, _ = motion_file.read(content(*(Page(name, BOW) for name in called))).motions(rows["bioloid"])
    assert [one.name for one in found] == names


def test_servos_without_a_joint_of_another_type_or_beyond_their_range_stay_and_are_told(rows):
    file = MtnFile((Page("bow", (step(s5=5000),)),), (*ENABLED, 19), (0, 2, *[0] * 24))
    (bow,), notes = motion_file.read(mtn.write(file)).motions(rows["bioloid"])
    assert not {"right_shoulder_pitch", "right_elbow"} & set(bow.frames[0].positions)
    assert [(note.table, note.row) for note in notes] == [("motor_type", "1"), ("enable", "19"), ("page", "1")]
    with pytest.raises(InputError, match="moves no servo"):
        motion_file.read(mtn.write(file._replace(enabled=(25,)))).motions(rows["bioloid"])
    with pytest.raises(InputError, match="none of its pages"):
        motion_file.read(mtn.write(file._replace(pages=(Page("empty", ()),)))).motions(rows["bioloid"])


def test_whose_it_is_shows_in_its_servos(rows):
    found = motion_file.read(content(Page("Bow", BOW)))
    assert [name for name in rows if found.fits(rows[name])] == ["bioloid"]


@given(st.lists(st.tuples(st.floats(-0.2, 1.2), st.integers(10, 9000)), min_size=1, max_size=40))
def test_a_motion_written_as_a_file_is_the_same_within_a_count_and_its_units_of_time(rows, path):
    motion = Motion(
        name="sway", frames=tuple(KeyFrame(positions={"left_hip_pitch": at}, duration_s=ms / 1000) for at, ms in path)
    )
    written, _ = motion_files.exported("bioloid", motion, rows["bioloid"], ".mtn")
    (back,), _ = motion_files.read(written, ".mtn").motions(rows["bioloid"])  # type: ignore[union-attr]
    assert back.name == "sway"
    asked_s, had_s = (sum(frame.duration_s for frame in one.frames) for one in (motion, back))
    assert had_s == pytest.approx(asked_s, abs=0.01 * len(back.frames))
    ends = [frame.positions["left_hip_pitch"] for frame in back.frames if frame.positions]
    assert ends[-1] == pytest.approx(path[-1][0], abs=0.006)


def test_what_a_file_cannot_say_and_what_has_no_place_in_another_makers_are_told(rows):
    motion = Motion(
        name="nod",
        frames=(
            KeyFrame(positions={"left_elbow": -1.0}, duration_s=1.0),
            KeyFrame(positions={"left_knee": -1.0}, duration_s=1.0),
        ),
    )
    _, notes = motion_files.exported("bioloid", motion, rows["bioloid"], ".MTN")
    assert [note.column for note in notes] == ["positions"]
    with pytest.raises(InputError, match="has no motor in layer 'factory'"):
        motion_files.exported("bioloid", motion, rows["bioloid"], ".rbm")
    with pytest.raises(InputError, match="no joint 'tail'"):
        motion_file.write(
            Motion(name="x", frames=(KeyFrame(positions={"tail": 1.0}, duration_s=1.0),)), rows["bioloid"]
        )
