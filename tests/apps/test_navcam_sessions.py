import pytest

from lbr.apps.navcam.sessions import LIFE_S, MOST, Sessions

KEY = "k" * 43


class Clock:
    now = 1_000_000.0

    def __call__(self) -> float:
        return self.now


@pytest.fixture
def clock() -> Clock:
    return Clock()


@pytest.fixture
def path(tmp_path):
    return tmp_path / "navcam.sessions"


def test_a_session_goes_on_until_it_is_ended_also_over_a_restart(path, clock):
    sessions = Sessions(path, KEY, clock)
    first, second = sessions.begin(), sessions.begin()
    assert sessions.knows(first)
    assert Sessions(path, KEY, clock).knows(second)
    sessions.end(first)
    for known in (sessions, Sessions(path, KEY, clock)):
        assert not known.knows(first)
        assert known.knows(second)
    sessions.end_all()
    assert not Sessions(path, KEY, clock).knows(second)


def test_a_session_ends_by_itself(path, clock):
    sessions = Sessions(path, KEY, clock)
    cookie = sessions.begin()
    clock.now += LIFE_S - 1
    assert sessions.knows(cookie)
    clock.now += 2
    assert not sessions.knows(cookie)
    assert not Sessions(path, KEY, clock).knows(cookie)


def test_another_token_knows_no_session_and_the_file_is_no_way_in(path, clock):
    cookie = Sessions(path, KEY, clock).begin()
    assert not Sessions(path, "x" * 43, clock).knows(cookie)
    assert cookie not in path.read_text()
    assert path.stat().st_mode & 0o777 == 0o600
    for mark in Sessions(path, KEY, clock)._ends:
        assert not Sessions(path, KEY, clock).knows(mark)


@pytest.mark.parametrize("content", [b"", b"{", b"[]", b'{"x": "y"}', b'{"x": 9e999}', b"\xff"])
def test_a_file_that_is_broken_holds_no_session(path, clock, content):
    path.write_bytes(content)
    sessions = Sessions(path, KEY, clock)
    assert sessions._ends == {}
    assert sessions.knows(sessions.begin())


def test_a_file_makes_no_session_longer_than_one_may_be(path, clock):
    sessions = Sessions(path, KEY, clock)
    cookie = sessions.begin()
    clock.now -= 10 * LIFE_S  # the clock was ahead when it began
    assert not Sessions(path, KEY, clock).knows(cookie)


def test_there_are_only_so_many(path, clock):
    sessions = Sessions(path, KEY, clock)
    cookies = []
    for _ in range(MOST + 3):
        clock.now += 1
        cookies.append(sessions.begin())
    assert [sessions.knows(cookie) for cookie in cookies] == [False] * 3 + [True] * MOST
