"""What a motion was before: read backwards out of the changes of its rows."""

from msgspec.structs import replace

from lbr.apps.motions.commands.versions import versions
from lbr.database import edits
from lbr.messages.joints import KeyFrame, Motion, MotionRow, MotionStep, motions_of

ROBOT = "bioloid"


def bow(*angles, text=""):
    frames = tuple(KeyFrame(positions={"left_elbow": angle}, duration_s=0.5) for angle in angles)
    return Motion(name="bow", help=text, frames=frames)


class Story:
    """Saves one version after the other into a real database; each at a time of its own."""

    def __init__(self, database):
        self.database = database
        self.changes = []
        self.minutes = 0

    def save(self, motion, **more):
        before = max((one.id for one in self.database.revisions()), default=0)
        edits.write_rows(self.database, ROBOT, motion.rows, lambda _rows: (), **more)
        self.minutes += 1
        stamp = f"2026-03-01T10:{self.minutes:02d}:00.000Z"
        for change in self.database.changes(before):
            self.changes.append(replace(change, rows=tuple(replace(row, changed_at=stamp) for row in change.rows)))

    def now(self, name="bow"):
        rows = self.database.load(ROBOT)
        found = motions_of(rows.of(MotionRow), rows.of(MotionStep))
        return next((one for one in found if one.name == name), None)

    def told(self, name="bow"):
        return versions(self.now(name), self.changes, ROBOT, name)


def test_each_time_that_it_was_saved_is_a_version_newest_first(database):
    story = Story(database)
    saved = [bow(-0.1), bow(-0.1, -0.4, -0.2), bow(-0.3, text="deeper")]
    story.save(saved[0], create=True)
    for one in saved[1:]:
        story.save(one)
    told = story.told()
    assert [one.motion for one in told] == saved[::-1]
    assert [one.since[11:16] for one in told] == ["10:03", "10:02", "10:01"]
    assert [one.revision for one in told] == sorted((one.revision for one in told), reverse=True)


def test_what_came_with_the_robot_is_its_first_version(database):
    story = Story(database)
    shipped = story.now("wave")
    own = replace(shipped, name="nod")
    assert [(one.revision, one.since, one.motion) for one in story.told("wave")] == [(0, "", shipped)]
    story.save(replace(own, builtin=False), create=True)
    assert [one.motion for one in story.told("wave")] == [shipped]


def test_what_was_saved_twice_alike_is_one_version(database):
    story = Story(database)
    story.save(bow(-0.1), create=True)
    story.save(bow(-0.1))
    story.save(bow(-0.2))
    assert [one.motion for one in story.told()] == [bow(-0.2), bow(-0.1)]


def test_one_that_was_restored_is_a_version_again(database):
    story = Story(database)
    for one in (bow(-0.1), bow(-0.2), bow(-0.1)):
        story.save(one, create=story.now() is None)
    assert [one.motion for one in story.told()] == [bow(-0.1), bow(-0.2), bow(-0.1)]


def test_a_motion_that_is_gone_still_has_what_it_was(database, client):
    story = Story(database)
    story.save(bow(-0.1), create=True)
    before = database.revisions()[-1].id
    client.execute("DELETE FROM motion WHERE robot = 'bioloid' AND name = 'bow'")
    story.changes += database.changes(before)
    assert story.now() is None
    assert [one.motion for one in story.told()] == [bow(-0.1)]


def test_another_motion_and_another_robot_are_not_mixed_in(database):
    story = Story(database)
    story.save(bow(-0.1), create=True)
    story.save(replace(bow(-0.2), name="bow_low"), create=True)
    assert [one.motion for one in story.told()] == [bow(-0.1)]
    assert versions(None, story.changes, "uxa90", "bow") == ()


def test_there_are_no_more_than_people_look_through(database, monkeypatch):
    monkeypatch.setattr("lbr.apps.motions.commands.versions.MOST", 5)
    story = Story(database)
    for at in range(9):
        story.save(bow(-0.01 * (at + 1)), create=at == 0)
    assert len(story.told()) == 5


def test_a_revision_that_cannot_be_read_ends_what_is_known_and_nothing_else(database):
    story = Story(database)
    story.save(bow(-0.1), create=True)
    story.save(bow(-0.2))
    *rows, last = story.changes[-1].rows
    bad = replace(last, before={"positions": 7, "step": "x"}, changed_at="not a time")
    told = versions(story.now(), [*story.changes[:-1], replace(story.changes[-1], rows=(*rows, bad))], ROBOT, "bow")
    assert told[0].motion == bow(-0.2)
