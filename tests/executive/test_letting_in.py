"""`phone`, `pair`, `open` and `close` at the console: what they tell, what they change, and who may say them."""

import json
from itertools import count
from types import SimpleNamespace

import pytest
from click.testing import CliRunner
from hypothesis import given
from hypothesis import strategies as st
from msgspec.structs import replace

from lbr.bus import keys, tokens
from lbr.bus.access import everything
from lbr.bus.door import LanUser
from lbr.commands.token import command
from lbr.database import edits, store
from lbr.database.reading import Problem
from lbr.database.rows import TokenRow
from lbr.errors import InputError, RowError
from lbr.executive.planning import credentials, rights
from lbr.executive.planning import plan as plans
from lbr.executive.planning.console_lines import vocabulary
from lbr.executive.planning.process_specs import LAN
from lbr.executive.service.dispatch import Dispatcher, Sender
from lbr.executive.service.letting_in import LettingIn
from lbr.executive.service.pairing import Code
from lbr.messages.rows import by_table
from tests.support import databases
from tests.support.planning import planned, shipped

LOCAL = "https://lbr-3fa2.local:50000/"
OPEN = {
    "accepted": True,
    "local": LOCAL,
    "url": "https://192.168.1.5:50000/",
    "open": True,
    "tls": True,
    "reason": "shown",
}
CLOSED = {"accepted": True, "url": "http://127.0.0.1:50000/", "open": False, "tls": False, "reason": "closed"}


@pytest.fixture(scope="module")
def rows():
    return shipped("uxa90", "UPDATE capability SET enabled = 1 WHERE name = 'web'")


class Console:
    """A robot of rows, whose server listens at once where its row says."""

    def __init__(self, rows, *, address=True) -> None:
        self.rows = rows
        self.plan = planned(rows)
        self.codes: list[tuple[str, str]] = []
        self.edits: list[tuple[str, str, str]] = []
        self.answers = address
        self.words = LettingIn(
            self, lambda _name, _timeout_s: self.address(), clock=lambda: next(self.seconds), pause=lambda _s: None
        )
        self.seconds = count()

    @property
    def host(self) -> str:
        return json.loads(bytes(self.plan.units["web"].config.settings)).get("host", "127.0.0.1")

    def address(self):
        return (CLOSED if self.host == "127.0.0.1" else OPEN) if self.answers else None

    def pair(self, role, who):
        self.codes.append((role, who))
        return Code(digits="482913", role=role, by=who, ends_s=120.0)

    def listen_at(self, name, host, who):
        self.edits.append((name, host, who))
        changed = [
            replace(row, settings=json.dumps(json.loads(row.settings) | {"host": host})) if row.name == name else row
            for row in self.rows.capabilities
        ]
        self.rows = replace(self.rows, capabilities=tuple(changed))
        self.plan = planned(self.rows)


@pytest.fixture
def console(rows) -> Console:
    return Console(rows)


@pytest.fixture(autouse=True)
def own_home(tmp_path, monkeypatch):
    monkeypatch.setenv("LBR_HOME", str(tmp_path / "home"))


def test_open_changes_the_row_once_and_close_takes_it_back(console, wording):
    first, second = console.words.open("console"), console.words.open("console")
    assert console.edits == [("web", "0.0.0.0", "console")]
    wording(first.text, second.text)
    assert second.data == {"url": OPEN["url"], "open": True, "tls": True}
    assert "'web' is closed: only this machine reaches it" in console.words.close("console").text
    assert "closed already" in console.words.close("console").text
    assert console.edits[1:] == [("web", "127.0.0.1", "console")]


def test_a_code_comes_with_its_picture_its_time_and_what_the_browser_will_say(console):
    console.words.open("console")
    result = console.words.pair("view", "ann")
    assert console.codes == [("view", "ann")]
    assert f"482 913   at https://192.168.1.5:50000/ or {LOCAL}" in result.text
    assert result.data["local"] == LOCAL
    assert "good for 2 minutes" in result.text
    assert "role 'view'" in result.text
    assert "\u2580" in result.text, "no picture"
    shown = credentials.fingerprint_shown()
    assert f"is this one:\n{shown}" in result.text
    assert len(shown) == 95
    assert result.data["url"] == "https://192.168.1.5:50000/#pair=482913"
    assert result.data["digits"] == "482913"
    assert result.data["open"]
    assert result.data["svg"].startswith("<svg")
    assert result.data["fingerprint"] == shown


def test_where_only_this_machine_reaches_it_a_code_has_no_picture(console):
    result = console.words.pair("operate", "console")
    assert "'phone' opens it to your network" in result.text
    assert "\u2580" not in result.text


def test_phone_opens_a_closed_server_and_shows_one_code(console, wording):
    result = console.words.phone("console")
    assert console.edits == [("web", "0.0.0.0", "console")]
    assert console.codes == [("operate", "console")]
    assert result.data["url"] == "https://192.168.1.5:50000/#pair=482913"
    text, fingerprint, picture = result.text.partition(result.data["fingerprint"])
    assert len(picture.split()) > 8
    assert set(picture) == set("\n \u2580\u2584\u2588")
    wording(f"{text}{fingerprint and 'FINGERPRINT'}")
    assert console.words.pair("operate", "console").text in result.text


def test_phone_leaves_a_server_that_is_open_as_it_is(console):
    console.words.open("console")
    assert "close" not in console.words.phone("ann").text
    assert len(console.edits) == 1
    assert console.codes == [("operate", "ann")]


def test_phone_draws_no_code_while_the_server_is_not_back(rows):
    console = Console(rows)
    console.listen_at = lambda *edit: (Console.listen_at(console, *edit), setattr(console, "answers", False))
    result = console.words.phone("console")
    assert (result.code, result.reason_code, console.codes) == (1, "unreachable", [])
    assert "type 'phone' again" in result.text


def test_no_code_is_drawn_for_a_role_that_is_none_or_where_nothing_serves(rows):
    with pytest.raises(InputError, match="'host' is not a role that a phone may have"):
        Console(rows).words.pair("host", "console")
    silent = Console(rows, address=False)
    assert silent.words.pair("view", "console").reason_code == "unreachable"
    assert silent.codes == []


def test_a_server_whose_row_is_off_is_named(rows):
    off = tuple(replace(row, enabled=False) if row.name == "web" else row for row in rows.capabilities)
    words = Console(replace(rows, capabilities=off)).words
    for said in (words.phone, words.open, words.close, lambda who: words.pair("view", who)):
        with pytest.raises(InputError, match="'web' does not run: its row is disabled"):
            said("console")


@pytest.mark.parametrize("line", ["phone", "p", "pair", "/pair/view", "open", "close"])
def test_who_comes_in_is_for_admins_alone_on_a_page_too(rows, line):
    plan = planned(rows)
    vocabulary = _vocabulary(plan)
    robot = SimpleNamespace(plan=plan, vocabulary=vocabulary, record=lambda *_: None)
    dispatcher = Dispatcher(robot, None, {})  # with no bus, so that it would break if it went on
    assert dispatcher.execute(line, Sender("web:ann", "operate", page=True)).reason_code == "role"
    assert dispatcher.execute(line, Sender("web:ann", "admin", page=True)).reason_code not in {"role", "denied"}
    assert dispatcher.execute(line, Sender("ann", "operate")).reason_code == "role"


def _vocabulary(plan):
    return vocabulary(plan.rows, plan.kinds)


# -- rights ------------------------------------------------------------------------------------------------------------


def test_only_what_pairs_may_show_codes_and_none_may_say_lines_of_an_admin(rows):
    plan = planned(rows)
    each = {name: rights.of_unit(plan, unit).values() for name, unit in plan.units.items()}
    asking = {name for name, may in each.items() if any(keys.pair("uxa90") in one.ask for one in may)}
    assert asking == {"web"}
    assert keys.pair("uxa90") not in rights.of_local(plan).ask
    for name, unit in plan.units.items():
        may = rights.of_unit(plan, unit)
        users = list(may.values()) if unit.kind != LAN else []
        assert not any(keys.console("uxa90", "admin") in one.ask for one in users), (
            f"{name} could ask for codes itself: what pages say goes by keys.console_of_pages"
        )


def test_each_key_of_the_system_is_among_those_that_rights_are_given_over():
    known = [key.removesuffix("/**") for key in everything("lbr")]
    system = [
        keys.console("lbr", "view"),
        keys.console_of_pages("lbr"),
        keys.edit("lbr"),
        keys.pair("lbr"),
        keys.edit("lbr", "web"),
    ]
    assert all(any(f"{key}/".startswith(f"{one}/") for one in known if "@" in one) for key in system)


def test_who_has_the_token_already_is_told_nothing_of_it(rows):
    row = TokenRow(
        name="anas-phone", role="operate", hash=tokens.hashed("x"), created_at="2026-01-01T00:00:00.000Z",
        good_for="web", paired_from="192.168.1.7",
    )  # fmt: skip
    before = TokenRow(name="zoe", role="view", hash=row.hash, created_at=row.created_at)
    plan = planned(replace(rows, tokens=(before,)))
    after = planned(replace(rows, tokens=(row, before)))
    assert plans.difference(plan, after).follow == ("web",)
    secret = credentials.token_secret(b"", row.name, row.created_at)
    user = LanUser(name=row.name, role=row.role, secret=secret, hash=row.hash)
    assert plans.difference(plans.learnt(plan, "web", by_table([user])), after) == plans.Change()


# -- rows --------------------------------------------------------------------------------------------------------------


def test_one_setting_is_written_as_a_revision_and_the_others_stay(tmp_path):
    path = tmp_path / "robot.db"
    databases.fresh(path)
    databases.edit(path, "UPDATE capability SET settings = '{\"port\":  1234}' WHERE robot = 'uxa90' AND name = 'web'")
    with store.Database.open(path) as database:
        before = database.revision()
        after = edits.write_setting(database, "uxa90", "web", "host", "0.0.0.0", lambda _rows: ()).revision
        assert after == before + 1
        (row,) = [row for row in database.load("uxa90").capabilities if row.name == "web"]
        assert json.loads(row.settings) == {"port": 1234, "host": "0.0.0.0"}
        (change,) = database.revisions(before)
        assert (change.table, change.row_key) == ("capability", ("uxa90", "web"))
        assert edits.write_setting(database, "uxa90", "web", "host", "0.0.0.0", lambda _rows: ()).revision == after
        bad = Problem("capability", "uxa90/web", "settings", "no such host")
        with pytest.raises(RowError, match="no such host"):
            edits.write_setting(database, "uxa90", "web", "host", "x", lambda _rows: [bad]).good()
        with pytest.raises(InputError, match="there is no capability 'nothing'"):
            edits.write_setting(database, "uxa90", "nothing", "host", "x", lambda _rows: ())
        assert database.revision() == after


# -- tokens ------------------------------------------------------------------------------------------------------------


@given(st.text(max_size=80), st.lists(st.text(max_size=40), max_size=5))
def test_whatever_a_device_calls_itself_its_token_has_a_name_of_its_own(said, others):
    taken = [credentials.device_name(one, ()) for one in others]
    found = [credentials.device_name(said, taken)]
    for _ in range(3):
        found.append(credentials.device_name(said, [*taken, *found]))
    assert len({one.lower() for one in (*taken, *found)}) == len(set(map(str.lower, taken))) + 4
    assert all(tokens.check_name(one) for one in found)


@pytest.mark.parametrize(
    ("said", "name"),
    [
        ("Ana's iPhone", "Ana-s-iPhone"),
        ("", "phone"),
        ("日本", "phone"),
        ("Zoë", "Zoe"),
        ("a" * 80, "a" * 32),
        ("-x-", "x"),
    ],
)
def test_a_name_stays_what_people_know_it_by(said, name):
    assert credentials.device_name(said, ()) == name
    assert credentials.device_name(said, (name.upper(),)) == f"{name}-2"


def test_a_list_says_from_where_a_device_was_paired(tmp_path):
    databases.fresh(tmp_path / "robot.db")
    with store.Database.open(tmp_path / "robot.db") as database:
        database.add_token(databases.token("by-hand", "view", "h" * 64))
        database.add_token(databases.token("phone", "operate", "h" * 64, good_for="web", paired_from="192.168.1.7"))
    told = CliRunner().invoke(command, ["list", "--db", str(tmp_path / "robot.db")]).output.splitlines()
    assert told[1].startswith("phone    operate web  valid    since 20")
    assert told[1].endswith(", paired from 192.168.1.7")
    assert "paired" not in told[0]


def test_a_paired_token_is_a_row_like_any_with_where_it_came_from(tmp_path):
    databases.fresh(tmp_path / "robot.db")
    with store.Database.open(tmp_path / "robot.db") as database:
        made = credentials.new_token(database, "phone", "view", good_for="web", paired_from="192.168.1.7")
        (row,) = database.tokens()
        assert (row.name, row.role, row.good_for, row.paired_from) == ("phone", "view", "web", "192.168.1.7")
        assert tokens.fits(made.token.secret, row.hash)
        assert tokens.parse(str(made.token)) == made.token
