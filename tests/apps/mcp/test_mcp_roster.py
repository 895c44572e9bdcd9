"""The agents of a server over HTTP: a newcomer is let in where one of the others moves nothing."""

import asyncio

import pytest

from lbr.apps.mcp.roster import Roster
from lbr.errors import InputError
from tests.support import needs

needs.modules("mcp")


class Agent:
    """An agent that notes its end."""

    def __init__(self, motion=None):
        self.motion = motion
        self.closed = False

    async def close(self):
        self.closed = True


def test_an_agent_is_the_same_at_each_call():
    roster = Roster(2)
    assert roster.agent("ann", Agent) is roster.agent("ann", Agent)


def test_a_newcomer_takes_the_place_of_the_one_that_was_away_for_longest():
    async def calls():
        roster = Roster(2)
        ann, bob = roster.agent("ann", Agent), roster.agent("bob", Agent)
        roster.agent("ann", Agent)
        cyd = roster.agent("cyd", Agent)
        await roster.close()
        return roster.agent("ann", Agent) is ann, ann.closed, bob.closed, cyd.closed

    assert asyncio.run(calls()) == (True, True, True, True)


def test_an_agent_that_moves_the_robot_keeps_its_place():
    async def calls():
        roster = Roster(2)
        ann = roster.agent("ann", lambda: Agent(motion="drive"))
        bob = roster.agent("bob", Agent)
        cyd = roster.agent("cyd", lambda: Agent(motion="turn"))
        await asyncio.sleep(0)
        assert (ann.closed, bob.closed, cyd.closed) == (False, True, False)
        with pytest.raises(InputError) as refusal:
            roster.agent("dan", Agent)
        return refusal.value.code

    assert asyncio.run(calls()) == "busy"
