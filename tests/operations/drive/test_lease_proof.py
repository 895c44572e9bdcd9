"""The lease as a model: spin closes its states, finds every seeded error, and lbr's own decisions live its histories."""

import shutil
from dataclasses import replace

import pytest

from lbr.drivers.wheels import arming
from tests.models.lease import replay, spin
from tests.models.lease.replay import Driver, MismatchError, Replay
from tests.models.lease.seeded import PROPERTIES, SEEDED
from tests.models.lease.spin import DEEP, FINE_S, MODEL, Search, ticks
from tests.models.motion import broken

LACKING = [program for program in ("spin", "cc") if shutil.which(program) is None]
pytestmark = [
    pytest.mark.skipif(bool(LACKING), reason=f"not installed: {', '.join(LACKING)}; apt install spin gcc"),
    # it works and never waits: on a busy machine it takes as long as that gives it
]

STEPS = 100_000
WORLDS = ("ti", "tie", "tci", "tri", "trcei")
FOUND_BY = {
    broken.no_lapse: "ti",
    broken.resumes_after_reset: "tie",
    broken.ignores_estop: "tie",
    broken.ignores_holder: "ti",
    broken.believes_old_commands: "ti",
    broken.trusts_afar: "tri",
    broken.forgets_stops: "ti",
}


@pytest.fixture(scope="module")
def search(tmp_path_factory):
    return Search(tmp_path_factory.mktemp("lease"), FINE_S, quickly=True)


@pytest.fixture(scope="module")
def drawn():
    """Histories drawn by chance, each drawn once."""
    kept = {}

    def draw(world, seed):
        if (world, seed) not in kept:
            kept[world, seed] = spin.by_chance(seed, STEPS, FINE_S, world)
        return kept[world, seed]

    return draw


def lives(trace, world, **instead):
    """Return how often something moved in a history that lbr lives as the model does."""
    life = Replay(FINE_S, world, **instead)
    life.follow(trace)
    return life.moved


def differs(trace, world, **instead):
    """Return why lbr does not live a history as the model does, or nothing."""
    try:
        lives(trace, world, **instead)
    except MismatchError as err:
        return str(err)
    return ""


def test_the_times_of_the_model_have_the_order_of_lbrs_own():
    times = ticks(FINE_S)
    assert 1 < times["VALID"] < times["WATCHDOG"] <= times["INSIST"] < times["LEASE"] <= times["OFFER"]
    assert times["LATE"] < times["LEASE"]
    defaults = [line.split()[1:3] for line in MODEL.read_text().splitlines() if line.startswith("#define")]
    assert all([name, str(value)] in defaults for name, value in times.items())


def test_the_model_has_no_state_in_which_a_property_is_broken(search):
    found = search.run("", depth=DEEP // 60)
    assert found.closed
    assert found.broken == 0
    assert found.states > 100_000


@pytest.mark.parametrize("seeded", SEEDED, ids=lambda seeded: seeded.name)
def test_a_seeded_error_breaks_its_property_and_lbr_does_not_follow_it(search, seeded):
    found = search.run(seeded.world, seeded.number)
    assert found.broken == seeded.breaks
    assert seeded.breaks in PROPERTIES
    assert differs(found.trace, seeded.world)


@pytest.mark.parametrize("world", WORLDS)
def test_lbr_lives_what_the_model_lives(drawn, world):
    assert sum(lives(drawn(world, seed), world) for seed in (1, 2)) > 0


@pytest.mark.parametrize("kernel", FOUND_BY, ids=lambda kernel: kernel.__name__)
def test_a_kernel_that_is_broken_on_purpose_does_not_live_what_the_model_lives(drawn, kernel):
    world = FOUND_BY[kernel]
    assert any(differs(drawn(world, seed), world, decide=kernel) for seed in range(1, 5))


def keeps_the_last_setpoint(state, inhibit, now, valid_s):
    fresh = replace(state.setpoint, born=now) if state.setpoint else None
    return arming.tick(replace(state, setpoint=fresh), inhibit, now, valid_s)


def arms_on_a_motion(state, setpoint, now, valid_s):
    kept = arming.receive(state, replace(setpoint, powers=(0.0, 0.0)), now, valid_s)
    return arming.receive(kept, setpoint, now, valid_s)


def hears_no_emergency_stop(state, inhibit, now, valid_s):
    return arming.tick(state, inhibit if inhibit and inhibit.fault else None, now, valid_s)


@pytest.mark.parametrize(
    ("world", "driver"),
    [
        ("ti", {"tick": keeps_the_last_setpoint}),
        ("tci", {"receive": arms_on_a_motion}),
        ("tie", {"tick": hears_no_emergency_stop}),
    ],
    ids=["keeps the last setpoint", "arms on a motion", "hears no emergency stop"],
)
def test_a_driver_that_is_broken_on_purpose_does_not_live_what_the_model_lives(drawn, world, driver):
    assert any(differs(drawn(world, seed), world, driver=Driver(**driver)) for seed in range(1, 5))


def test_a_mismatch_says_where_and_what():
    trace = ("tick", "setpoint 1 0")
    assert differs(trace, "").startswith("line 2, 'setpoint 1 0': the drive says [MotorSetpoint(left=0.0")
    assert replay.SOURCES == ("console", "page")
