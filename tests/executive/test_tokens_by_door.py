"""Which tokens a process gets to know: those that are good for the way in which it opens, and no others."""

from typing import get_args

import msgspec
import pytest
from msgspec.structs import replace

from lbr.bus.door import LanUser
from lbr.bus.tokens import hashed
from lbr.database.rows import GoodFor, TokenRow
from lbr.executive.planning import plan as plans
from tests.support.planning import SITE, planned, shipped

TOKENS = tuple(
    TokenRow(name=door, role="operate", hash=hashed("x"), created_at="2026-01-01T00:00:00.000Z", good_for=door)
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


def test_the_web_server_is_told_of_a_revoked_token_and_never_of_a_secret(plan):
    without = made(tuple(one for one in TOKENS if one.name != "web"))
    assert "web" in plans.difference(plan, without).follow
    told = plans.changed_rows(plan.units["web"], without.units["web"])
    assert (told.rows, told.gone) == ({"user_token": "[]"}, {"user_token": '[["web"]]'})
    assert "web" in plans.difference(without, plan).restart
