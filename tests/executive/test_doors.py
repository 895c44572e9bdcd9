"""Where processes come in: at the core, or at an annex that knows rights which the core does not."""

from contextlib import closing
from pathlib import Path

import pytest
from msgspec.structs import replace

from lbr.database import store
from lbr.executive import plan as plans
from lbr.executive.doors import Doors, core_endpoint
from lbr.executive.profile import Profile
from lbr.executive.site import Site


def test_rights_that_come_back_need_no_further_annex(home: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("LBR_HOME", str(home))
    site = Site(home=str(home), endpoints=(core_endpoint("lbr"),), secret=b"s" * 32)
    with store.Database.open(home / "robot.db") as database:
        rows = database.load("lbr")
    without = replace(rows, channels=tuple(one for one in rows.channels if one.target_end[0] != "drive"))
    found = [plans.make(one, Profile(robot="lbr", simulate=True), site)[0] for one in (rows, without)]
    with closing(Doors(found[0], site)) as doors:  # type: ignore[arg-type]
        places = [doors.place(plan, plan.units["drive"]).endpoint for plan in 3 * found if plan is not None]
    assert places[0] == core_endpoint("lbr") != places[1]
    assert places == 3 * places[:2]
