"""Which tokens a process gets to know: those that are good for the way in which it opens, and no others."""

from typing import get_args

import msgspec
import pytest
import zenoh
from msgspec.structs import replace

from lbr.bus import keys
from lbr.bus.door import LanUser
from lbr.capability import registry
from lbr.database.rows import GoodFor, TokenRow
from lbr.executive.planning import plan as plans
from lbr.executive.planning import rights
from tests.support.planning import SITE, planned, shipped

TOKENS = tuple(
    TokenRow(name=door, role="operate", hash="h" * 32, created_at="2026-01-01T00:00:00.000Z", good_for=door)
    for door in get_args(GoodFor)
)


def made(tokens):
    return planned(replace(shipped("uxa90"), tokens=tokens), site=replace(SITE, listen=("tls/10.0.0.1:7447",)))


@pytest.fixture(scope="module")
def plan():
    return made(TOKENS)


def test_the_web_server_does_not_know_a_token_for_the_bus(plan):
    users = msgspec.json.decode(plan.units["web"].config.rows["user_token"].rows, type=list[LanUser])
    assert {user.name for user in users} == {"web", "both"}


def test_the_door_to_other_machines_does_not_know_a_token_for_the_web(plan):
    assert {user.name for user in plan.units["lan"].lan.users} == {"bus", "both"}


def test_a_token_that_is_added_or_revoked_restarts_no_server(plan):
    without = made(tuple(one for one in TOKENS if one.name != "web"))
    for before, after in ((plan, without), (without, plan)):
        change = plans.difference(before, after)
        assert "web" in change.follow
        assert not change.restart
    told = plans.changed_rows(plan.units["web"], without.units["web"])
    assert (told.rows, told.gone) == ({"user_token": "[]"}, {"user_token": '[["web"]]'})


@pytest.mark.parametrize("kind", ["web", "foxglove", "mcp"])
def test_each_server_with_tokens_follows_them(kind, tmp_path):
    assert {read.row for read in registry.find(kind, tmp_path).reads if read.followed} >= {LanUser}


def test_a_secret_goes_to_its_reader_alone_and_nobody_but_the_executive_sends_it(plan):
    """Zenoh delivers a query to those that serve its key; a wildcard matches no chunk that begins with `@`."""
    key = keys.edit("uxa90", "web")
    users = {user: one for unit in plan.local_units.values() for user, one in rights.of_unit(plan, unit).items()}
    assert [user for user, one in users.items() if key in one.serve] == ["web"]
    allowed = [*users.values(), rights.of_local(plan)]
    assert not [expr for one in allowed for expr in (*one.ask, *one.put) if zenoh.KeyExpr(expr).intersects(key)]
