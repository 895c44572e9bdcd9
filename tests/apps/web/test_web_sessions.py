import pytest

from lbr.apps.web.sessions import LIFE_S, MOST, Sessions, name_in
from lbr.errors import InputError

KEY = {"ann": "k" * 43}
BOTH = KEY | {"bob": "b" * 43}
ME, OTHER, ELSEWHERE = "user 1000", "user 1001", ""


class Clock:
    now = 1_000_000.0

    def __call__(self) -> float:
        return self.now


def knows(sessions: Sessions, cookie: str, whose: str = ME) -> bool:
    return sessions.knows(sessions.find(cookie, whose))


def end(sessions: Sessions, cookie: str, whose: str = ME) -> None:
    sessions.end(sessions.find(cookie, whose))


@pytest.fixture
def clock() -> Clock:
    return Clock()


@pytest.fixture
def path(tmp_path):
    return tmp_path / "navcam.sessions"


def test_a_session_goes_on_until_it_is_ended_also_over_a_restart(path, clock):
    sessions = Sessions(path, KEY, clock)
    first, second = sessions.begin("ann", ME), sessions.begin("ann", ME)
    assert knows(sessions, first)
    assert knows(Sessions(path, KEY, clock), second)
    end(sessions, first)
    for known in (sessions, Sessions(path, KEY, clock)):
        assert not knows(known, first)
        assert knows(known, second)
    sessions.end_all("ann")
    assert not knows(Sessions(path, KEY, clock), second)


def test_a_session_ends_by_itself(path, clock):
    sessions = Sessions(path, KEY, clock)
    cookie = sessions.begin("ann", ME)
    clock.now += LIFE_S - 1
    assert knows(sessions, cookie)
    clock.now += 2
    assert not knows(sessions, cookie)
    assert not knows(Sessions(path, KEY, clock), cookie)


def test_another_token_knows_no_session_and_the_file_is_no_way_in(path, clock):
    cookie = Sessions(path, KEY, clock).begin("ann", ME)
    assert not knows(Sessions(path, {"ann": "x" * 43}, clock), cookie)
    assert cookie not in path.read_text()
    assert path.stat().st_mode & 0o777 == 0o600
    for mark in Sessions(path, KEY, clock)._ends:
        assert not knows(Sessions(path, KEY, clock), mark)


@pytest.mark.parametrize("content", [b"", b"{", b"[]", b'{"x": "y"}', b'{"x": 9e999}', b"\xff", b'{"\xff": 1}'])
def test_a_file_that_is_broken_holds_no_session(path, clock, content):
    path.write_bytes(content)
    sessions = Sessions(path, KEY, clock)
    assert sessions._ends == {}
    assert knows(sessions, sessions.begin("ann", ME))


def test_a_session_that_cannot_be_written_lasts_as_long_as_its_server_and_whoever_ends_it_is_told(tmp_path, clock):
    (tmp_path / "full").write_text("")
    sessions = Sessions(tmp_path / "full" / "navcam.sessions", KEY, clock)
    cookie = sessions.begin("ann", ME)
    assert knows(sessions, cookie)
    with pytest.raises(InputError):
        end(sessions, cookie)
    assert not knows(sessions, cookie)


def test_a_file_makes_no_session_longer_than_one_may_be(path, clock):
    sessions = Sessions(path, KEY, clock)
    cookie = sessions.begin("ann", ME)
    clock.now -= 10 * LIFE_S  # the clock was ahead when it began
    assert not knows(Sessions(path, KEY, clock), cookie)


def test_there_are_only_so_many(path, clock):
    sessions = Sessions(path, KEY, clock)
    cookies = []
    for _ in range(MOST + 3):
        clock.now += 1
        cookies.append(sessions.begin("ann", ME))
    assert [knows(sessions, cookie) for cookie in cookies] == [False] * 3 + [True] * MOST


def test_a_session_is_of_the_user_alone_who_began_it(path, clock):
    sessions = Sessions(path, KEY, clock)
    for mine, others in ((ME, (OTHER, ELSEWHERE)), (ELSEWHERE, (ME, OTHER))):
        cookie = sessions.begin("ann", mine)
        for other in others:
            assert not knows(sessions, cookie, other)
            end(sessions, cookie, other)
        assert knows(sessions, cookie, mine)


def test_each_session_is_of_one_token_and_ends_with_it(path, clock):
    sessions = Sessions(path, BOTH, clock)
    anns, bobs = sessions.begin("ann", ME), sessions.begin("bob", ME)
    assert [name_in(sessions.find(cookie, ME)) for cookie in (anns, bobs)] == ["ann", "bob"]
    marks = [sessions.find(cookie, ME) for cookie in (anns, bobs)]
    assert [Sessions(path, KEY, clock).knows(mark) for mark in marks] == [True, False]  # bob's token was revoked
    sessions.end_all("ann")
    assert [sessions.knows(mark) for mark in marks] == [False, True]
    sessions.use(KEY)
    assert [sessions.knows(name) for name in ("", "ann", "bob")] == [False, True, False]
    assert sessions.find(bobs, ME) == ""
