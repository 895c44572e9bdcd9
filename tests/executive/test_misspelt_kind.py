"""A misspelt kind is refused in a robot that runs, also where a component is broken that might have had it."""

import sqlite3

import pytest

from lbr import plugins
from lbr.database.store import Database
from lbr.executive.planning.machine import ANY
from lbr.executive.planning.profile import load
from lbr.executive.planning.run_identity import RunIdentity
from lbr.executive.planning.watch import RowWatch
from tests.support import databases


@pytest.fixture
def client(tmp_path, monkeypatch):
    """Edit the rows of a robot whose speech is of a component that is broken."""
    databases.fresh(tmp_path / "robot.db")
    monkeypatch.setattr(plugins, "broken", lambda: ("component 'talk', which does not load",))
    connection = sqlite3.connect(tmp_path / "robot.db", isolation_level=None)
    connection.execute("UPDATE capability SET kind = 'talk' WHERE robot = 'lbr' AND name = 'speech'")
    yield connection
    connection.close()


def test_an_edit_with_a_misspelt_kind_is_refused_whole_and_another_is_not(client, tmp_path):
    site = RunIdentity(home=str(tmp_path), endpoints=("tcp/h:1",), secret=b"secret", token_key=b"key")
    with Database.open(tmp_path / "robot.db") as database:
        watch = RowWatch(database, load("lbr-sim"), site, lambda _processes: ANY)
        plan = watch.first()
        assert "speech" not in plan.units
        client.execute("BEGIN")
        client.execute("UPDATE capability SET settings = json_set(settings, '$.max_power', 0.3) WHERE name = 'drive'")
        client.execute("UPDATE capability SET kind = 'motion_dirver' WHERE robot = 'lbr' AND name = 'motors'")
        client.execute("COMMIT")
        refused = watch.look(plan)
        assert refused.plan is None
        assert "capability 'lbr/motors', kind: there is no kind 'motion_dirver'" in refused.problems[0]
        client.execute("UPDATE capability SET kind = ? WHERE robot = 'lbr' AND name = 'motors'", ("roboteq",))
        assert "drive" in watch.look(plan).change.restart
