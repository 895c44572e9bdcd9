"""What a console tells of what happens, beside the answers to its own lines."""

from lbr.console.event_filter import TOLD_S, EventFilter
from lbr.messages.system import ConsoleResult, Event


class Clock:
    now = 10.0

    def __call__(self):
        return self.now


def event(text, subject="world", kind="refused", level="warning", code="refused", about=""):
    return Event(kind=kind, subject=subject, text=text, level=level, code=code, about=about)


def answer(code):
    return ConsoleResult(code=1, text="in any words", reason_code=code)


def test_a_refusal_that_was_just_answered_is_not_told_again():
    news = EventFilter("console")
    news.answered(answer("unknown_name"))
    mine = event("console: no emulated device 'nope'", code="unknown_name", about="console")
    of_another = event("phone: no emulated device 'nope'", code="unknown_name", about="phone")
    other = event("console: too many", code="busy", about="console")
    assert news.sifted([mine, of_another, other]) == [of_another, other]


def test_what_an_answer_says_is_news_again_later():
    clock = Clock()
    news = EventFilter("console", clock)
    news.answered(answer("done"))
    changed = event("'obstacle' has vanished", level="info", kind="world_changed", code="done", about="console")
    assert not news.sifted([changed])
    clock.now += TOLD_S + 0.1
    assert news.sifted([changed])


def test_the_start_of_a_program_is_told_to_those_who_did_not_start_it():
    started = event("'clock' is started by console", subject="executive", kind="external", code="", about="console")
    assert not EventFilter("console").sifted([started])
    assert EventFilter("console@2").sifted([started]) == [started]


def test_what_a_motion_asked_of_the_joints_is_told_by_the_motion_alone():
    end = event("motions: reached in 1.50 s", "joints", "reached", "info", code="done", about="motions")
    fault = event("motions: left_knee has latched overload", "joints", "fault", code="latched", about="motions")
    of_another = event("phone: 'wave' was played", "motions", "reached", "info", code="done", about="phone")
    assert EventFilter("console").sifted([end, fault, of_another]) == [fault, of_another]
    news = EventFilter("console")
    news.answered(answer("latched"))
    assert not news.sifted([fault])


def test_the_same_twice_within_seconds_is_told_once():
    lost = event("device 'imu' does not answer", subject="imu", kind="degraded")
    back = event("ready", subject="imu", kind="recovered", level="info")
    assert EventFilter("console").sifted([back, lost, lost, back]) == [back, lost, back]


def test_python_typed_here_is_for_the_record():
    typed = event("console: 1+1", subject="executive", kind="python", level="info", about="console")
    assert not EventFilter("console").sifted([typed])
    assert EventFilter("console@2").sifted([typed]) == [typed]


def test_what_a_joint_or_a_rule_does_is_told_to_those_who_asked_for_it_too():
    switched = event("console switched the torque of all joints on", "joints", "torque", "info", code="")
    limited = event("the forward rule stops the base: forward 0.20 m", "drive", "rule", code="obstacle")
    news = EventFilter("console")
    news.answered(answer("done"))
    assert news.sifted([switched, limited]) == [switched, limited]
