"""What may follow the name of an external command: what a row lists or fits, and never an option beside."""

import os
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from lbr.database import arguments
from tests.support.waiting import until

SIDES = ("left", "right")


@pytest.mark.parametrize(
    ("allowed", "given_", "why"),
    [
        ((), (), ""),
        ((), ("-f",), "takes no arguments"),
        ((), ("",), "takes no arguments"),
        ((SIDES,), (), ""),
        ((SIDES,), ("left",), ""),
        ((SIDES,), ("lef",), "takes as its first argument left or right, not 'lef'"),
        ((SIDES,), ("left", "right"), "takes at most 1 argument"),
        ((SIDES, "[0-9]+"), ("left", "12"), ""),
        ((SIDES, "[0-9]+"), ("left", "12\n"), "takes as its second argument what fits [0-9]+, not '12?'"),
        (("[0-9]+",), ("12 -f",), "takes as its first argument what fits [0-9]+, not '12 -f'"),
        (("a|b",), ("ab",), "takes as its first argument what fits a|b, not 'ab'"),
        ((".*",), ("-f/etc/passwd",), "takes as its first argument what fits .*, not '-f/etc/passwd'"),
        (("(?s).*",), ("a\nb",), "takes as its first argument what fits (?s).*, not 'a?b'"),
        ((r"\d+",), ("\u0661",), "takes as its first argument what fits \\d+, not '\u0661'"),
        (("a*",), ("a" * 201,), f"takes as its first argument what fits a*, not '{'a' * 40}…'"),
        ((("-u",),), ("-u",), ""),
        (((".*",),), ("x",), "takes as its first argument .*, not 'x'"),
    ],
)
def test_arguments_are_what_the_row_allows(allowed, given_, why):
    assert arguments.refusal(allowed, given_) == why


def test_a_pattern_that_python_would_think_about_for_ever_is_given_up_and_ranks_behind_the_robot_meanwhile():
    with ThreadPoolExecutor() as pool:
        told = pool.submit(arguments.refusal, ("(a+)+b",), ("a" * 60,))
        until(
            lambda: any(_nice(pid) == 19 for pid in _children()), what="what compares ranks last, and holds nobody up"
        )
        assert not told.done()
        assert told.result().startswith("takes as its first argument what fits (a+)+b")


def _children():
    return [int(pid) for task in Path("/proc/self/task").iterdir() for pid in (task / "children").read_text().split()]


def _nice(pid):
    try:
        return os.getpriority(os.PRIO_PROCESS, pid)
    except ProcessLookupError:
        return None


@given(st.text(max_size=30), st.sampled_from([".*", "(?s).*", "-?.*", "(-|x).*", r"\W*\w*"]))
def test_no_pattern_takes_an_option(text, pattern):
    assert arguments.refusal((pattern,), (f"-{text}",))


@pytest.mark.parametrize(
    ("column", "fault"),
    [
        ([["left"], "x+"], ""),
        ([[]], "entry 1 is neither a list of words"),
        ([["left"], ["a", 1]], "entry 2 is neither a list of words"),
        ([None], "entry 1 is neither"),
        ([""], "entry 1 is neither"),
        (["("], "entry 1 is not a regular expression"),
        (["x" * 201], "entry 1 is neither"),
        ([["a\n"]], "entry 1 is neither"),
        ([["a"]] * 17, "allows more than 16 arguments"),
    ],
)
def test_what_the_column_may_say(column, fault):
    assert arguments.fault(column).startswith(fault)
    assert bool(arguments.fault(column)) == bool(fault)
