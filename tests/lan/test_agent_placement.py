"""What a profile may place on another machine, what goes there with it, and what it may do when it comes back in."""

import msgspec
import pytest
from msgspec.structs import replace

from lbr.bus.tokens import hashed
from lbr.database.rows import RobotRows, TokenRow
from lbr.executive.planning import profile as profiles
from lbr.executive.planning import rights
from lbr.executive.planning.plan import Plan
from lbr.executive.planning.profile import Profile
from lbr.executive.remote.host_protocol import HostReport, HostShare, Placed, mark
from lbr.executive.remote.remote_hosts import RemoteHosts
from lbr.messages.system import CapabilityStatus, Event
from tests.support import planning

SITE = replace(planning.SITE, listen=("tls/10.0.0.1:7447",))
TOKEN = TokenRow(name="operator", role="host", hash=hashed("x"), created_at="2026-01-01T00:00:00.000Z")
STATE = CapabilityStatus(
    name="dance", kind="dance", phase="ready", pid=7, restarts=0, uptime_s=1.0, reason="", rates_hz={}
)


@pytest.fixture(scope="module")
def rows() -> RobotRows:
    return replace(planning.shipped("lbr"), tokens=(TOKEN,))


@pytest.fixture(scope="module")
def bioloid() -> RobotRows:
    return replace(planning.shipped("bioloid"), tokens=(TOKEN,))


def planned(rows: RobotRows, *names: str, simulate: bool = True) -> Plan:
    return planning.planned(rows, Profile(robot="lbr", simulate=simulate, hosts={"operator": names}), SITE)


def refused(rows: RobotRows, **profile: object) -> str:
    return "\n".join(planning.problems(rows, Profile(robot="lbr", **profile)))  # type: ignore[arg-type]


@pytest.mark.parametrize(
    "name",
    [
        "motors",
        "drive",
        "world",
        "lan",
        "imu",
    ],
)
def test_what_moves_a_motor_or_owns_a_device_stays(rows, name, wording):
    wording(refused(rows, simulate=True, hosts={"operator": (name,)}))


def test_a_device_may_be_plugged_in_elsewhere_if_the_profile_says_so(rows):
    hosts = {"operator": ("imu",)}
    assert 'say so in the profile: plugged_in_elsewhere = ["imu"]' in refused(rows, hosts=hosts)
    plan = planning.planned(rows, Profile(robot="lbr", hosts=hosts, plugged_in_elsewhere=("imu",)), SITE)
    assert "imu" not in plan.local_units


def test_a_profile_that_places_what_is_not_there_or_twice_is_refused(rows):
    said = refused(rows, hosts={"operator": ("danse", "dance"), "Bench 2": ("dance",)}, plugged_in_elsewhere=("imu",))
    for words in (
        "there is no capability 'danse'",
        "'Bench 2' is not a host's name",
        "'dance' is placed on 'operator' already",
        "'imu' is placed on no host",
    ):
        assert words in said


@pytest.mark.parametrize("name", ["bioloid-two", "bioloid-two-sim"])
def test_the_shipped_profiles_of_two_machines_place_attitude_and_motions(bioloid, name):
    plan = planning.planned(bioloid, profiles.load(name), SITE)
    assert {unit.name: unit.config.host for unit in plan.units.values() if unit.config.host} == {
        "attitude": "operator",
        "motions": "operator",
    }
    assert {"joints", "servos"} <= set(plan.local_units)


def test_nothing_of_a_process_that_stays_leaves_the_robot(rows):
    plan = planned(rows, "attitude", "dance")
    document = msgspec.json.encode([plan.units[name] for name in ("attitude", "dance")]).decode()
    own = {
        f"lbr/{one}"
        for one in (
            "imu/sample",
            "drive/state",
            "attitude/state",
            "attitude/calibration",
            "dance/state",
            "speech/state",
        )
    }
    for unit in plan.local_units.values():
        assert unit.config.release_key not in document
        assert unit.config.credentials is not None
        assert unit.config.credentials.password not in document
        for wire in (wire for wires in unit.config.outputs.values() for wire in wires):
            assert wire.key in own or wire.seal not in document or not wire.seal
    assert "unixsock" not in document
    assert "/nowhere" not in document


def test_a_share_survives_the_way_over_the_bus(rows):
    unit = planned(rows, "dance").units["dance"]
    share = HostShare(accepted=True, units=(Placed(unit=unit),))
    assert msgspec.json.decode(msgspec.json.encode(share), type=HostShare).units == share.units


def test_what_is_elsewhere_has_its_rights_at_the_door_and_none_at_the_core(rows):
    plan = planned(rows, "dance")
    lan = plan.units["lan"].lan
    assert lan is not None
    (guest,) = lan.guests
    assert guest.credentials.user == "operator.dance"
    assert "lbr/drive/command" in guest.rights.ask
    assert lan.theirs == {"lbr/dance/play": "operate"}
    assert "lbr/dance/play" not in lan.commands
    link = rights.of_unit(plan, plan.units["lan"])[lan.link.user]
    assert "lbr/dance/state" in link.put
    assert "lbr/dance/play" in link.serve
    assert "lbr/@alive/dance" in link.alive
    assert not set(lan.commands) & {*link.put, *link.ask, *link.serve}, "what may begin motion is relayed"
    assert not {"lbr/drive/state", "lbr/motors/setpoint"} & {*link.put, *link.serve}


def test_without_its_token_a_host_has_nothing_that_comes_in(rows):
    plan = planned(replace(rows, tokens=()), "dance")
    assert plan.units["dance"].config.credentials is None
    assert plan.units["lan"].lan is not None
    assert plan.units["lan"].lan.guests == ()
    executive = Executive(plan)
    assert executive.hosts.capabilities()["dance"].reason.endswith("lbr token add operator --role host")
    renewed = planned(replace(rows, tokens=(replace(TOKEN, created_at="2027-01-01T00:00:00.000Z"),)), "dance")
    assert renewed.units["dance"].config.credentials != planned(rows, "dance").units["dance"].config.credentials


class Asked:
    """A report on the wire, and its answer."""

    def __init__(self, report: HostReport | bytes) -> None:
        self.payload = report if isinstance(report, bytes) else msgspec.json.encode(report)

    def reply(self, answer, _source):
        self.answer = answer


class Wire:
    def __init__(self):
        self.waiting = []

    def take(self):
        taken, self.waiting = self.waiting, []
        return taken


class Executive:
    """The executive's side of two hosts, of which `operator` has agents that report."""

    def __init__(self, plan):
        self.wire, self.told, self.learnt, self.begun, self.now = Wire(), [], [], [], 100.0
        self.present = {"dance"}
        self.hosts = RemoteHosts(
            {"operator": self.wire, "bench": Wire()},
            version="1",
            happened=lambda *about: self.told.append(about[:4]),
            learnt=lambda *learnt: self.learnt.append(learnt),
            begun=self.begun.append,
            present=lambda name: name in self.present,
        )
        self.hosts.adopt(plan)

    def answer(self, agent="one", **said):
        asked = Asked(HostReport(agent=agent, where="desk, pid 1", **said))
        self.wire.waiting.append(asked)
        self.hosts.step(self.now)
        return asked.answer


@pytest.fixture
def executive(rows):
    return Executive(planned(rows, "dance"))


def test_an_agent_gets_its_share_once_and_again_when_somebody_asks_for_a_restart(executive):
    first = executive.answer()
    assert [one.unit.name for one in first.units] == ["dance"]
    assert first.share == mark(first.units)
    assert executive.answer(share=first.share).units is None
    assert executive.hosts.restart("dance")
    assert not executive.hosts.restart("drive")
    assert executive.answer(share=first.share).units[0].restarts == 1


def test_what_it_reports_is_told_and_is_told_of_its_own_processes_only(executive):
    forged = Event(kind="holder", subject="drive", text="forged")
    own = Event(kind="crashed", subject="dance", text="crashed: of itself", level="error")
    unheard = Event(kind="estop_reset", subject="dance", text="of another kind")
    executive.answer(states=(STATE, replace(STATE, name="drive")), events=(forged, unheard, own))
    assert executive.hosts.capabilities() == {"dance": replace(STATE, host="operator")}
    assert ("crashed", "dance", "crashed: of itself", "error") in executive.told
    assert not [about for about in executive.told if about[1] == "drive" or about[0] == "estop_reset"]
    assert executive.begun == ["dance"]


def test_a_second_agent_is_refused_until_the_first_is_silent(executive, wording):
    executive.answer(states=(STATE,))
    second = executive.answer(agent="two")
    wording(second)
    assert second.units is None
    executive.now += 4.0
    executive.hosts.step(executive.now)
    assert executive.told[-1][:2] == ("host_lost", "operator")
    assert "gone with it: dance" in executive.told[-1][2]
    assert "lbr agent operator --connect tls/" in executive.hosts.capabilities()["dance"].reason
    assert executive.answer(agent="two").accepted


def test_one_whose_link_is_lost_is_gone_at_once(executive):
    executive.answer()
    executive.present = {"operator.agent"}
    executive.answer(states=(STATE,))
    assert executive.hosts.capabilities()["dance"].phase == "starting", "it cannot be asked from here yet"
    executive.present = set()
    executive.hosts.step(executive.now)
    assert executive.told[-1][2] == "the agent at desk, pid 1 is out of reach; gone with it: dance"


def test_one_that_leaves_is_gone_at_once_and_a_robot_that_ends_says_so(executive):
    executive.answer(states=(STATE,))
    executive.answer(leaving=True)
    assert executive.told[-1][:3] == (
        "host_lost",
        "operator",
        "the agent at desk, pid 1 has ended; gone with it: dance",
    )
    executive.hosts.end()
    assert executive.answer(agent="two").ended


def test_a_report_that_cannot_be_read_is_answered_in_words(executive):
    asked = Asked(b'{"agent": 5}')
    executive.wire.waiting.append(asked)
    executive.hosts.step(executive.now)
    assert "malformed report" in asked.answer.reason
