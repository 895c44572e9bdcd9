"""The face `model`: the body of this robot and the poses of its motions, as answers."""

from typing import Any

import msgspec
import pytest

from lbr.apps.web.face import Client, Refused, Route
from lbr.apps.web.model import PORTS
from lbr.apps.web.model.building import MotionParams
from lbr.apps.web.model.poses import key_pose
from lbr.apps.web.model.routes import ModelFace, MotionBody
from lbr.messages.faces import EditReply
from lbr.messages.joints import Joint, KeyFrame, Motion
from tests.apps.web.asking import called, modelled

ELBOW = Joint(name="left_elbow", device_id=6, side="left", lower_rad=-1.9, upper_rad=0.1, speed_rps=3.0)


def frame(**positions: float) -> KeyFrame:
    return KeyFrame(positions=positions, duration_s=0.5)


WAVE = Motion(
    name="wave", frames=(frame(arm=0.1), frame(arm=1.5, hand=0.2), frame(hand=-0.4), frame(arm=0.0, hand=0.0))
)


@pytest.fixture
def routes(tmp_path) -> dict[str, Any]:
    robot = modelled(tmp_path, joints=(ELBOW,), motions=(WAVE,), motion={WAVE.name: WAVE}.get)
    return {route.path: route for route in ModelFace(robot).routes() if route.method == "GET"}


def asked(route: Route, **more: Any) -> Any:
    return called(route, Client("127.0.0.1", role="view"), **more)


def test_the_body_is_answered_with_limits_and_told_once(routes):
    first = asked(routes["/api/model"])
    told = msgspec.json.decode(first.body)
    assert (told["robot"], told["joints"]["left_elbow"]["lower"]) == ("bioloid", -1.9)
    assert len(told["links"]) == 19
    again = asked(routes["/api/model"], headers={"if-none-match": first.headers["etag"]})
    assert (again.status_code, again.body) == (304, b"")


def test_a_body_of_the_owners_own_is_read_again_when_it_changed(routes, tmp_path):
    before = asked(routes["/api/model"]).headers["etag"]
    own = tmp_path / "models" / "bioloid.xml"
    own.parent.mkdir()
    own.write_text("<mujoco/>")
    told = msgspec.json.decode(asked(routes["/api/model"]).body)
    assert str(own) in told["reason"]
    assert told["joints"]["left_elbow"]["drawn"] is False
    own.unlink()
    assert asked(routes["/api/model"]).headers["etag"] == before


def run(work: Any) -> Any:
    """Run a handler that waits for nothing."""
    with pytest.raises(StopIteration) as ended:
        work.send(None)
    return ended.value.value


def test_a_motion_is_shown_by_the_pose_that_is_furthest_from_its_ends(routes):
    answer = run(asked(routes["/api/poses"]))
    assert msgspec.json.decode(answer.body) == {"poses": {"wave": {"arm": 1.5, "hand": -0.4}}}
    assert key_pose(Motion(name="still", frames=())) == {}
    assert key_pose(Motion(name="sit", frames=(frame(arm=1.0), frame(hand=0.3)))) == {"arm": 1.0, "hand": 0.3}


def test_a_motion_is_answered_with_its_key_frames(routes):
    answer = run(asked(routes["/api/motion"], params=MotionParams(motion="wave")))
    assert msgspec.json.decode(answer.body, type=Motion) == WAVE
    handler = asked(routes["/api/motion"], params=MotionParams(motion="nod"))
    with pytest.raises(Refused, match="no motion 'nod'"):
        handler.send(None)


class Editor:
    """Takes rows as the executive does, or refuses them."""

    def __init__(self, reply: EditReply) -> None:
        self.reply = reply
        self.edits: list[tuple[Any, bool]] = []

    async def edit(self, rows: Any, *, create: bool, by: str) -> EditReply:
        self.edits.append((rows, create))
        return self.reply


def kept(tmp_path, reply: EditReply, **given: Any) -> tuple[Editor, Any]:
    """Post a motion to a robot that answers edits like this."""
    editor = Editor(reply)
    robot = modelled(tmp_path, joints=(ELBOW,), motions=(WAVE,), motion={WAVE.name: WAVE}.get, edit=editor.edit)
    post = next(route for route in ModelFace(robot).routes() if route.method == "POST")
    return editor, asked(post, body=MotionBody(frames=(frame(left_elbow=-0.5),), **given))


def test_a_motion_is_kept_as_rows(tmp_path):
    editor, answer = kept(tmp_path, EditReply(accepted=True), name="bow")
    assert run(answer).status_code == 200
    rows, create = editor.edits[0]
    assert create
    assert [row.TABLE for row in rows] == ["motion", "motion_step"]


def test_one_that_is_there_is_replaced_only_when_that_is_said(tmp_path):
    editor, answer = kept(tmp_path, EditReply(accepted=True), name="wave", replace=True)
    run(answer)
    assert editor.edits[0][1] is False


def test_what_the_robot_refuses_is_told_with_its_code(tmp_path):
    reply = EditReply(accepted=False, reason="left_elbow: 9 is outside", code="bad_value")
    _, answer = kept(tmp_path, reply, name="bow")
    with pytest.raises(Refused, match="left_elbow: 9") as refused:
        answer.send(None)
    assert (refused.value.status, refused.value.code) == (409, "bad_value")


def test_it_reads_what_a_body_is_made_of_and_writes_motions_alone():
    assert {row.TABLE for row in PORTS.rows} == {"joint", "wheel", "range_sensor", "motion", "motion_step"}
    assert {row.TABLE for row in PORTS.edits} == {"motion", "motion_step"}
