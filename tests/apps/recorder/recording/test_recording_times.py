"""Times as people say them."""

from datetime import datetime, timedelta

import pytest
from hypothesis import given
from hypothesis import strategies as st

from lbr.apps.recorder.recording import times
from lbr.errors import InputError

NOW = datetime(2026, 3, 14, 15, 9, 26).astimezone()
NOW_NS = int(NOW.timestamp()) * 10**9


@pytest.mark.parametrize(
    ("said", "meant"),
    [
        ("now", NOW),
        ("90", NOW - timedelta(seconds=90)),
        ("10m", NOW - timedelta(minutes=10)),
        ("10 min ago", NOW - timedelta(minutes=10)),
        ("1.5h", NOW - timedelta(minutes=90)),
        ("3d", NOW - timedelta(days=3)),
        ("14:02", NOW.replace(hour=14, minute=2, second=0)),
        ("14:02:30", NOW.replace(hour=14, minute=2, second=30)),
        ("16:00", NOW.replace(hour=16, minute=0, second=0) - timedelta(days=1)),
        ("yesterday 9:30", NOW.replace(hour=9, minute=30, second=0) - timedelta(days=1)),
        ("2026-03-01 08:00", datetime(2026, 3, 1, 8, 0).astimezone()),
        ("2026-03-01T08:00:00Z", datetime.fromisoformat("2026-03-01T08:00:00+00:00")),
    ],
)
def test_people_are_understood(said, meant):
    assert abs(times.moment_ns(said, NOW_NS) - meant.timestamp() * 1e9) < 1e6


@pytest.mark.parametrize("said", ["99x", "25:00", "14:60", "soon", "-5m", "9" * 400, "nan"])
def test_what_is_no_time_is_refused_with_how_times_are_said(said):
    with pytest.raises(InputError, match="such as 10m"):
        times.moment_ns(said, NOW_NS)


@given(st.text(max_size=40))
def test_any_text_is_a_time_or_refused(text):
    try:
        assert times.moment_ns(text, NOW_NS) >= 0
    except InputError:
        return
