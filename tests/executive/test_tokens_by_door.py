"""Which tokens a process gets to know: those that are good for the way in which it opens, and no others."""

from typing import get_args

import msgspec
import pytest
from msgspec.structs import replace

from lbr.bus.door import LanUser
from lbr.bus.tokens import hashed
from lbr.database.rows import GoodFor, TokenRow
from tests.support.planning import SITE, planned, shipped


@pytest.fixture
def plan():
    tokens = tuple(
        TokenRow(name=door, role="operate", hash=hashed("x"), created_at="2026-01-01T00:00:00.000Z", good_for=door)
        for door in get_args(GoodFor)
    )
    return planned(replace(shipped("uxa90"), tokens=tokens), site=replace(SITE, listen=("tls/10.0.0.1:7447",)))


def test_the_web_server_does_not_know_a_token_for_the_bus(plan):
    users = msgspec.json.decode(plan.units["web"].config.rows["user_token"].rows, type=list[LanUser])
    assert {user.name for user in users} == {"web", "both"}


def test_the_door_to_other_machines_does_not_know_a_token_for_the_web(plan):
    assert {user.name for user in plan.units["lan"].lan.users} == {"bus", "both"}
