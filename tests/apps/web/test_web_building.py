"""What the motion builder asks: checks, files, versions; done by processes that are bounded, and ended."""

import gzip
import time
from pathlib import Path
from typing import Any

import msgspec
import pytest

from tests.support import needs

needs.modules("mujoco")

from lbr.apps.bodies import motion_forms  # noqa: E402
from lbr.apps.web.face import Client, Refused  # noqa: E402
from lbr.apps.web.model.building import CheckBody, CheckParams, MotionParams, ReadBody, UploadBody, WriteBody  # noqa: E402
from lbr.apps.web.model.routes import ModelFace, MotionBody  # noqa: E402
from lbr.apps.web.model.uploads import KEPT_S, MOST_BYTES, MOST_UPLOADS, Uploads  # noqa: E402
from lbr.apps.web.model.work import MOST_AT_ONCE, UNASKED_S, Work, Works  # noqa: E402
from lbr.messages.faces import EditReply  # noqa: E402
from lbr.messages.joints import Joint, KeyFrame, Motion  # noqa: E402
from lbr.messages.motion_work import LONGEST_CHECK_S, CheckJob, NotDone, ReadJob, VersionsJob  # noqa: E402
from tests.apps.web.asking import called, modelled  # noqa: E402
from tests.support import databases  # noqa: E402

ELBOW = Joint(name="left_elbow", device_id=6, side="left", lower_rad=-1.9, upper_rad=0.1, speed_rps=3.0)
BIOLOID = databases.of_robot("bioloid").of(Joint)
STAND = (KeyFrame(positions={"left_elbow": -0.5, "right_elbow": 0.5}, duration_s=0.6),)
TOPPLE = (KeyFrame(positions={"left_ankle_pitch": 0.8, "right_ankle_pitch": -0.8}, duration_s=0.5),)
WAVE = Motion(name="wave", frames=STAND)
PHONE = Client("127.0.0.1", role="operate")


class Stage:
    """The face `model` without a server: its rounds are the test's."""

    def __init__(self, home: Path, joints: tuple[Joint, ...] = (ELBOW,)) -> None:
        self.edits: list[Any] = []
        robot = modelled(home, joints=joints, motions=(WAVE,), motion={WAVE.name: WAVE}.get, edit=self._edit)
        self.face = ModelFace(robot)
        self.routes = {(route.method, route.path): route for route in self.face.routes()}

    async def _edit(self, rows: Any, *, create: bool, by: str) -> EditReply:
        self.edits.append(rows)
        return EditReply(accepted=True)

    def ask(self, method: str, path: str, *, client: Client = PHONE, **more: Any) -> dict[str, Any]:
        """Ask, and go on for as long as the answer takes."""
        answer = called(self.routes[method, path], client, **more)
        while True:
            try:
                answer.send(None)
            except StopIteration as ended:
                return msgspec.json.decode(ended.value.body)
            self.face.step(time.monotonic())
            time.sleep(0.01)

    def send(self, content: bytes, name: str = "a", size: int = 1000, client: Client = PHONE) -> str:
        packed = gzip.compress(content)
        for part, at in enumerate(range(0, len(packed), size)):
            body = UploadBody(upload=name, part=part, content=packed[at : at + size])
            self.ask("POST", "/api/motion/upload", body=body, client=client)
        return name

    def check(self, **more: Any) -> dict[str, Any]:
        number = self.ask("POST", "/api/motion/check", body=CheckBody(**more))["check"]
        while True:
            self.face.step(time.monotonic())
            found = self.ask("GET", "/api/motion/check", params=CheckParams(check=number))
            if found.get("report"):
                return found["report"]
            time.sleep(0.02)


@pytest.fixture
def stage(tmp_path):
    found = Stage(tmp_path)
    yield found
    found.face.close()


@pytest.fixture
def humanoid(tmp_path):
    found = Stage(tmp_path, BIOLOID)
    yield found
    found.face.close()


def frames(count: int) -> bytes:
    one = KeyFrame(positions={"left_elbow": -0.5}, duration_s=0.1)
    return msgspec.json.encode({"name": "bow", "frames": [one] * count})


def test_a_motion_of_a_thousand_key_frames_is_kept_though_no_body_is_as_large(stage):
    stage.send(frames(1000))
    stage.ask("POST", "/api/motion", body=MotionBody(name="bow", upload="a"))
    assert len(stage.edits[0]) == 1001


def test_ten_thousand_key_frames_are_refused_with_what_may_be(stage):
    stage.send(frames(10_000))
    with pytest.raises(Refused, match="1000") as refused:
        stage.ask("POST", "/api/motion", body=MotionBody(name="bow", upload="a"))
    assert refused.value.status == 400


def test_a_motion_without_key_frames_is_not_kept(stage):
    with pytest.raises(Refused, match="no key frames"):
        stage.ask("POST", "/api/motion", body=MotionBody(name="bow"))


def test_what_one_sends_another_cannot_name(stage):
    stage.send(frames(1))
    other = Client("192.168.1.9", name="ben", role="operate")
    with pytest.raises(Refused, match="was not sent"):
        stage.ask("POST", "/api/motion/write", body=WriteBody(upload="a"), client=other)


def test_parts_follow_one_another_and_are_taken_once():
    clock = [0.0]
    uploads = Uploads(lambda: clock[0])
    packed = gzip.compress(b"x" * 5000)
    with pytest.raises(Refused, match="begin with part 0"):
        uploads.add("anna", "a", 1, packed)
    assert uploads.add("anna", "a", 0, packed[:20]) == 20
    with pytest.raises(Refused, match="begin with part 0"):
        uploads.add("anna", "a", 2, packed[20:])
    uploads.add("anna", "a", 1, packed[20:])
    assert uploads.take("anna", "a") == b"x" * 5000
    with pytest.raises(Refused, match="not sent"):
        uploads.take("anna", "a")


def test_uploads_are_bounded_in_number_in_size_and_in_time():
    clock = [0.0]
    uploads = Uploads(lambda: clock[0])
    for number in range(MOST_UPLOADS):
        uploads.add("anna", str(number), 0, b"x")
    with pytest.raises(Refused, match="too much"):
        uploads.add("ben", "a", 0, b"x")
    clock[0] += KEPT_S + 1
    uploads.add("ben", "a", 0, gzip.compress(bytes(MOST_BYTES + 1)))
    with pytest.raises(Refused, match="no motion needs"):
        uploads.take("ben", "a")
    uploads.add("ben", "a", 0, gzip.compress(b"half of it")[:-4])
    with pytest.raises(Refused, match="a part is missing"):
        uploads.take("ben", "a")
    uploads.add("ben", "a", 0, b"no gzip")
    with pytest.raises(Refused, match="not packed"):
        uploads.take("ben", "a")


def test_a_check_says_that_a_motion_stands_and_shows_how_near_it_came(humanoid):
    humanoid.send(msgspec.json.encode({"frames": STAND}))
    report = humanoid.check(upload="a")
    assert (report["stands"], report["begins"], report["body"]) == (True, True, "bioloid")
    assert report["least_mm"] > 10
    assert {one["frame"] for one in report["trace"]} == {1}
    assert all(len(one["support"]) >= 3 for one in report["trace"])


def test_a_check_says_when_a_motion_falls_and_in_which_key_frame(humanoid):
    humanoid.send(msgspec.json.encode({"frames": [*STAND, *TOPPLE]}))
    report = humanoid.check(upload="a")
    assert (report["stands"], report["begins"], report["falls_frame"]) == (False, True, 2)
    assert 0.6 < report["falls_s"] < 4.0
    assert report["trace"][-1]["tilt_rad"] > 0.8


def test_what_is_no_motion_of_this_robot_is_refused_by_the_process(stage):
    stage.send(msgspec.json.encode({"frames": TOPPLE}))
    with pytest.raises(Refused, match="no joint 'left_ankle_pitch'"):
        stage.check(upload="a")


def test_a_check_is_bounded_in_what_it_plays(stage):
    long = [KeyFrame(positions={"left_elbow": -0.1 * (at % 2)}, duration_s=60.0) for at in range(11)]
    stage.send(msgspec.json.encode({"frames": long}))
    with pytest.raises(Refused, match=f"{LONGEST_CHECK_S:.0f} s is the most"):
        stage.check(upload="a")


def test_another_check_of_the_same_page_ends_the_first_and_each_is_its_own(stage):
    first = stage.ask("POST", "/api/motion/check", body=CheckBody(motion="wave"))["check"]
    second = stage.ask("POST", "/api/motion/check", body=CheckBody(motion="wave"))["check"]
    with pytest.raises(Refused, match=f"no check {first}"):
        stage.ask("GET", "/api/motion/check", params=CheckParams(check=first))
    other = Client("192.168.1.9", name="ben", role="operate")
    with pytest.raises(Refused, match=f"no check {second}"):
        stage.ask("GET", "/api/motion/check", params=CheckParams(check=second), client=other)
    stage.ask("DELETE", "/api/motion/check", params=CheckParams(check=second))
    assert stage.face.jobs == 0 or stage.face.step(0.0) is None
    assert stage.face.jobs == 0


class Patient:
    """A job that never ends by itself."""

    def __init__(self, _job: Any, now: float) -> None:
        self.result: Any = None
        self.asked_s = now
        self.part = 0.0

    def step(self, now: float) -> None:
        if now - self.asked_s > UNASKED_S:
            self.end(NotDone(reason="not asked for"))

    def end(self, result: Any) -> None:
        self.result = result


def test_only_so_many_are_under_way_and_what_is_not_asked_for_ends():
    clock = [0.0]
    works = Works(lambda: clock[0], Patient)  # type: ignore[arg-type]
    job = VersionsJob(robot="r", database="", motion="wave")
    begun = [works.start(job, asked=True) for _ in range(MOST_AT_ONCE)]
    assert works.start(job) is None
    clock[0] += UNASKED_S + 0.1
    assert works.start(job) is not None
    assert all(one is not None and one.result is not None for one in begun)
    works.close()
    assert works.count == 0


def test_a_process_that_is_ended_is_gone():
    job = CheckJob(robot="bioloid", home="/nowhere", joints=BIOLOID, frames=STAND)
    work = Work(job, time.monotonic())
    process = work._process
    assert process is not None
    work.end(NotDone(reason="cancelled"))
    assert process.returncode is not None


def test_a_file_comes_back_as_it_was_written_and_a_foreign_one_is_named(humanoid):
    humanoid.send(msgspec.json.encode({"name": "bow", "frames": STAND}))
    for form in (".json", ".mtn"):
        humanoid.send(msgspec.json.encode({"name": "bow", "frames": STAND}))
        written = msgspec.convert(humanoid.ask("POST", "/api/motion/write", body=WriteBody(upload="a", form=form)), Any)
        content = msgspec.convert(written["content"], bytes)
        humanoid.send(content, "b")
        found = humanoid.ask("POST", "/api/motion/read", body=ReadBody(upload="b", file=f"bow{form}"))
        (motion,) = found["motions"]
        assert motion["name"] == "bow"
        assert abs(motion["frames"][-1]["positions"]["left_elbow"] + 0.5) < 0.01
    humanoid.send(b"\x89PNG no motion", "c")
    with pytest.raises(Refused, match="not a motion") as refused:
        humanoid.ask("POST", "/api/motion/read", body=ReadBody(upload="c", file="photo.png"))
    assert refused.value.status == 400


def test_without_a_database_there_are_no_versions_and_it_is_said_why(stage):
    with pytest.raises(Refused, match="is not there"):
        stage.ask("GET", "/api/motion/versions", params=MotionParams(motion="wave"))


def test_the_forms_are_told_with_what_is_only_read(stage):
    answer = called(stage.routes["GET", "/api/motion/forms"], PHONE)
    known = {one["suffix"]: one["writes"] for one in msgspec.json.decode(answer.body)["forms"]}
    assert known == {".json": True, ".mtn": True, ".rbm": False}
    assert {one for one, _, writes in motion_forms.known("uxa90") if writes} == {".json", ".rbm"}
    assert {one for one, _, writes in motion_forms.known("a_robot_of_rows") if writes} == {".json", ".mtn", ".rbm"}


def test_a_file_that_says_nothing_ends_its_process_with_a_sentence():
    work = Work(ReadJob(content=b"", suffix=".mtn", joints=(ELBOW,)), time.monotonic())
    while work.result is None:
        work.step(time.monotonic())
        time.sleep(0.01)
    assert isinstance(work.result, NotDone)
    assert work.result.reason
