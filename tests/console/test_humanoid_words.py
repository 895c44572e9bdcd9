"""What can be said to the Bioloid, by its shipped rows and the messages of its kinds."""

import pytest
from hypothesis import given
from hypothesis import strategies as st
from prompt_toolkit.completion import CompleteEvent
from prompt_toolkit.document import Document

from lbr.console.completion import LineCompleter
from lbr.console.confirmation import Confirmation
from lbr.console.operator import Telemetry
from lbr.console.toolbar import joints, power, toolbar
from lbr.console.verbs import VerbCall, Vocabulary
from lbr.errors import InputError
from lbr.messages.joints import JointsState, JointState
from lbr.messages.power import PowerState, UpsState
from lbr.messages.system import ConsoleResult
from lbr.operations.joints import KIND as JOINTS
from lbr.operations.motions import KIND as MOTIONS
from lbr.operations.power import KIND as POWER
from lbr.simulation.commands.joint_table import lines
from tests.support.words import as_shipped

ROWS = as_shipped("bioloid")
MESSAGES = {
    f"{kind.name}.{command}": message for kind in (JOINTS, MOTIONS, POWER) for command, message in kind.messages.items()
}
WORDS = Vocabulary(ROWS.verbs, ROWS.external_commands, MESSAGES)
NAMES = {
    "joints.move.joint": ["left_elbow", "right_elbow", "left_knee"],
    "joints.torque.joints": ["left_elbow", "right_elbow"],
    "motions.play.motion": ["sit", "stand"],
}


def said(line: str) -> tuple[str, dict]:
    call = WORDS.parse(line)
    assert isinstance(call, VerbCall)
    return f"{call.capability}.{call.command}", call.payload


@pytest.mark.parametrize(
    ("line", "target", "payload"),
    [
        ("/j/left_elbow/-45", "joints.move", {"joint": "left_elbow", "angle_deg": -45.0}),
        ("/j/left_elbow/-45/90", "joints.move", {"joint": "left_elbow", "angle_deg": -45.0, "speed_dps": 90.0}),
        ("/torque/on", "joints.torque", {"on": True}),
        ("/torque/on/left_elbow", "joints.torque", {"on": True, "joints": ["left_elbow"]}),
        (
            "/torque/off/left_elbow, right_elbow",
            "joints.torque",
            {"on": False, "joints": ["left_elbow", "right_elbow"]},
        ),
        ("/torque/off/all", "joints.torque", {"on": False, "confirmed": True}),
        ("/play/sit", "motions.play", {"motion": "sit"}),
        ("/play/sit/3", "motions.play", {"motion": "sit", "times": 3}),
        ("/play/sit/3/0.5", "motions.play", {"motion": "sit", "times": 3, "speed": 0.5}),
        ("/mirror/sit", "motions.play", {"motion": "sit", "mirror": True}),
        ("/pose/sit", "motions.play", {"motion": "sit", "times": 1}),
        ("/capture/mine/0.5", "motions.capture", {"motion": "mine", "duration_s": 0.5}),
        ("recover", "joints.recover", {}),
        ("/recover/left_knee", "joints.recover", {"joints": ["left_knee"]}),
        ("arm", "power.arm", {"armed": True}),
        ("/arm/10.8/10.2", "power.arm", {"armed": True, "warn_v": 10.8, "shutdown_v": 10.2}),
        ("cancel", "power.cancel", {}),
        ("S", "executive.stop", {}),
    ],
)
def test_a_line_becomes_its_message(line, target, payload):
    assert said(line) == (target, payload)


@pytest.mark.parametrize(
    ("line", "why"),
    [
        ("/j/left_elbow/400", "angle is -360 to 360 degrees, not 400"),
        ("/j/left_elbow/-45/fast", "speed is above 0, up to 1000 degrees a second, not 'fast'"),
        ("/play/sit/0", "times is 1 to 1000, not 0"),
        ("/torque/on/Left Elbow", "joints 'Left Elbow' is not a name"),
        ("/torque/on/left_elbow,", "joints '' is not a name"),
    ],
)
def test_what_cannot_be_is_refused_in_one_line(line, why):
    with pytest.raises(InputError) as refused:
        WORDS.parse(line)
    assert why in str(refused.value)


@given(
    st.text(max_size=40) | st.lists(st.sampled_from(["left_knee", ",", "all", "/", " ", "é"]), max_size=9).map("".join)
)
def test_any_list_of_joints_is_read_or_refused_in_one_printable_line(text):
    line = f"/torque/off/{text}"
    assert refusal(line).isprintable()


def refusal(line: str) -> str:
    try:
        WORDS.parse(line)
    except InputError as err:
        return str(err)
    return ""


def test_letting_go_of_all_joints_needs_a_word_more_and_of_one_does_not():
    outright = WORDS.confirming(WORDS.parse("/torque/off"))
    assert outright.pattern == "/torque/off/all"
    for line in ("/torque/off/all", "/torque/off/left_elbow", "/torque/on", "/play/sit", "s"):
        assert WORDS.confirming(WORDS.parse(line)) is None


@pytest.mark.parametrize(
    ("typed", "offered"),
    [
        ("/j/l", ["left_elbow", "left_knee"]),
        ("/torque/o", ["off", "on"]),
        ("/torque/on/r", ["right_elbow"]),
        ("/play/", ["sit", "stand"]),
        ("/mirror/st", ["stand"]),
    ],
)
def test_joints_and_motions_complete(typed, offered):
    completer = LineCompleter(WORDS.entries(NAMES))
    event = CompleteEvent(completion_requested=True)
    assert [one.text for one in completer.get_completions(Document(typed), event)] == offered


# a question


@pytest.mark.parametrize(
    ("answer", "meant"),
    [("y", "/torque/off/all"), (" YES ", "/torque/off/all"), ("", None), ("n", None), ("s", "s"), ("/x/1", "/x/1")],
)
def test_only_a_yes_does_it_and_another_line_is_that_line(answer, meant):
    question = Confirmation()
    question.ask(ConsoleResult(code=1, text="", confirm="/torque/off/all"))
    assert question.answer(answer) == meant
    assert not question.open
    assert question.answer("y") == "y", "it was asked once"


def test_a_yes_that_comes_late_is_no_answer():
    now = [0.0]
    question = Confirmation(lambda: now[0])
    question.ask(ConsoleResult(code=1, text="", confirm="/torque/off/all"))
    now[0] = 31.0
    assert question.answer("y") == "y"


# the bar


def body(**more) -> JointsState:
    each = {
        "left_knee": JointState(id=14, torque=1.0, temperature_c=48.0, voltage_v=11.2),
        "right_knee": JointState(id=13, torque=1.0, temperature_c=41.0, voltage_v=10.9),
    }
    fields = {"sequence": 1, "measured_s": 0.0, "moving": False, "phase": "following", "joints": each} | more
    return JointsState(**fields)


def bar(**telemetry) -> str:
    return "".join(text for _, text in toolbar("bioloid", Telemetry(**telemetry), None, {}))


def test_the_bar_of_a_humanoid_tells_of_joints_and_power_and_of_no_base():
    state = body(moving=True, holder="console")
    ups = UpsState(valid=True, source="external", external_v=11.1)
    known = PowerState(phase="watching", armed=True, warn_v=10.5, shutdown_v=9.9, ups=ups)
    assert bar(joints=state, power=known) == (
        " bioloid | listening | joints moving | held by console | left_knee 48 °C | 10.9 V at the joints"
        " | external 11.1 V"
    )


@pytest.mark.parametrize(
    ("fields", "words"),
    [
        ({"phase": "released"}, "joints torque off"),
        ({"phase": "holding"}, "joints mover lost: holding"),
        ({"phase": "releasing"}, "joints mover lost: releasing"),
        ({}, "joints holding"),
        ({"joints": {"a": JointState(id=1, torque=0.0), "b": JointState(id=2, torque=1.0)}}, "1 without torque"),
        ({"joints": {"a": JointState(id=1, torque=1.0, trusted=False)}}, "joints holding, 1 not believed"),
        ({"moving": True, "stored": 4, "left_s": 1.6}, "controller plays slot 4, 2 s more"),
        ({"joints": {"left_knee": JointState(id=1, latched=("overload",))}}, "latched: left_knee overload"),
        ({"joints": {"a": JointState(id=1, torque=1.0, temperature_c=None)}}, "joints holding"),
        ({"joints": {"a": JointState(id=1), "b": JointState(id=2, torque=1.0)}}, "holding, torque of 1 of 2 unknown"),
        ({"phase": "released", "joints": {"a": JointState(id=1)}}, "joints torque of 1 of 1 unknown"),
    ],
)
def test_what_the_joints_do_is_said_in_words(fields, words):
    assert any(words in text for _, _, text in joints(body(**fields)))


def test_the_table_says_of_a_joint_that_it_is_weak_not_believed_or_without_torque(wording):
    of = {
        "a": JointState(id=1, torque=0.4),
        "b": JointState(id=2, trusted=False, raw=200, reason="it jumped"),
        "c": JointState(id=3, torque=0.0, reason="was released"),
    }
    first, _, *rows = lines(body(joints=of, moving=True, stored=4, left_s=1.6), None, 100, 20)
    wording(first)
    assert [row.split("  ")[-1] for row in rows] == [
        "torque 40 %",
        "says 200, not believed, torque unknown",
        "was released, no torque",
    ]


@pytest.mark.parametrize(
    ("fields", "words"),
    [
        ({"phase": "countdown", "remaining_s": 8.2}, "SHUTDOWN in 8 s"),
        ({"phase": "warning", "reason": "external supply 10.2 V"}, "power warning: external supply 10.2 V"),
        ({"phase": "disarmed", "armed": False}, "power watch disarmed"),
    ],
)
def test_what_the_power_does_is_said_in_words(fields, words):
    state = PowerState(**({"phase": "watching", "armed": True, "warn_v": 10.5, "shutdown_v": 9.9} | fields))
    assert [text for _, _, text in power(state)] == [words]
