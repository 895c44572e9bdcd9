"""Questions about the past: answered from a thread, refused when too many wait, and survived when a file goes meanwhile."""

import threading
from types import SimpleNamespace

import pytest

from lbr.apps.recorder.box.past import MOST_WAITING, Past, read_history, read_then
from lbr.apps.recorder.messages import HistoryCommand, HistoryReply, ThenCommand
from lbr.apps.recorder.recording.shelf import Shelf
from lbr.testing.context import FakeCall
from tests.support.waiting import until

S = 1_000_000_000


@pytest.fixture
def past(tmp_path):
    past = Past(SimpleNamespace(wake=lambda: None), Shelf(tmp_path, "r"))
    yield past
    past.close()


def answered(past, call):
    until(lambda: past.step() or call.answer)
    return call.answer


def test_an_empty_box_has_a_history_without_points_and_no_moment(past):
    history = FakeCall("history", HistoryCommand(fields=("battery/state.voltage_v",), from_ns=0, to_ns=S))
    past.ask(history, read_history)
    assert answered(past, history).at_ms == []
    then = FakeCall("then", ThenCommand(at_ns=S, part="drive"))
    past.ask(then, read_then)
    assert not answered(past, then).accepted


def test_a_file_that_goes_while_it_is_read_is_a_refusal(past):
    def gone(_shelf, _asked):
        raise FileNotFoundError("00000001.mcap")

    call = FakeCall("then", ThenCommand(at_ns=S, part="drive"))
    past.ask(call, gone)
    assert answered(past, call).code == "unreachable"


def test_more_questions_than_may_wait_are_refused_and_the_others_are_answered(past):
    go = threading.Event()

    def slow(_shelf, _asked):
        go.wait()
        return HistoryReply(accepted=True)

    calls = [FakeCall("history", None) for _ in range(MOST_WAITING + 1)]
    for call in calls:
        past.ask(call, slow)
    assert calls[-1].answer.code == "busy"
    go.set()
    assert all(answered(past, call).accepted for call in calls[:-1])
