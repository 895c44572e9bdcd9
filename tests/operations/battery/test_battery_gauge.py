import msgspec
import pytest
from hypothesis import given
from hypothesis import strategies as st

from lbr.messages.motors import MotorsState, MotorState
from lbr.operations.battery import AGM_12V, KIND, charge_at
from lbr.operations.battery.gauge import Gauge

PERIOD_S = 0.2
BARE = '{"internal_ohm": 0, "idle_a": 0, "filter_s": 0}'


def motors(voltage_v: float | None, **more) -> MotorsState:
    return MotorsState(
        **({"left": 0.0, "right": 0.0, "armed": True, "reason": "", "estop": False} | more), voltage_v=voltage_v
    )


class Measured:
    """A gauge and its time."""

    def __init__(self, settings: str = BARE) -> None:
        self.gauge = Gauge(KIND.parse(settings))
        self.now = 100.0

    def see(self, voltage_v: float | None, for_s: float = 0.0, **more):
        for _ in range(max(1, round(for_s / PERIOD_S))):
            self.now += PERIOD_S
            self.gauge.see(motors(voltage_v, **more), self.now)
        return self.gauge.state(self.now)

    def drive(self, voltage_v: float, for_s: float):
        for count in range(round(for_s / PERIOD_S)):
            self.see(voltage_v, left=0.3, right=0.3, counts_left=count, counts_right=count)


@pytest.mark.parametrize(
    ("voltage_v", "charge"),
    [(10.4, 0.0), (10.5, 0.0), (11.3, 0.1), (12.0, 0.5), (12.45, 0.75), (12.7, 1.0), (12.8, 1.0)],
)
def test_charge_lies_between_the_entries_of_the_table(voltage_v, charge):
    assert charge_at(voltage_v, AGM_12V) == pytest.approx(charge)
    state = Measured().see(voltage_v, for_s=2.0)
    assert state.valid
    assert state.charge == pytest.approx(charge)
    assert state.source == "battery"


@given(st.floats(), st.floats())
def test_more_voltage_is_never_less_charge(one, other):
    low, high = sorted((one, other)) if one == one and other == other else (0.0, 0.0)
    assert 0.0 <= charge_at(low, AGM_12V) <= charge_at(high, AGM_12V) <= 1.0


def test_a_load_does_not_look_like_an_empty_battery():
    measured = Measured('{"internal_ohm": 0.05, "idle_a": 2.0, "filter_s": 0}')
    state = measured.see(11.9, for_s=2.0, left=0.5, right=-0.5, amps_left_a=20.0, amps_right_a=-16.0)
    assert state.current_a == pytest.approx(18.0)
    assert state.rest_voltage_v == pytest.approx(12.9)
    assert state.voltage_v == pytest.approx(11.9)


def test_one_wrong_voltage_changes_nothing():
    measured = Measured()
    measured.see(12.4, for_s=3.0)
    assert measured.see(3.0).level == "ok"
    assert measured.see(60.0).rest_voltage_v == 12.4
    assert measured.see(12.4).charge == pytest.approx(0.7)


@pytest.mark.parametrize("voltage_v", [None, float("nan"), 0.0, -12.0, float("inf")])
def test_what_is_no_voltage_is_passed_over_and_in_the_end_there_is_none(voltage_v, wording):
    measured = Measured()
    assert not measured.see(voltage_v).valid
    wording(measured.see(voltage_v).reason)
    measured.see(12.4, for_s=2.0)
    assert measured.see(voltage_v).valid
    late = measured.see(voltage_v, for_s=3.0)
    assert (late.valid, late.charge, late.level) == (False, None, "unknown")
    wording(late.reason)


def test_a_voltage_is_shown_smoothed():
    measured = Measured('{"internal_ohm": 0, "idle_a": 0, "filter_s": 2}')
    measured.see(12.0, for_s=3.0)
    assert 12.0 < measured.see(12.4, for_s=1.4).rest_voltage_v < 12.35
    assert measured.see(12.4, for_s=20.0).rest_voltage_v == pytest.approx(12.4)


def test_a_charger_is_known_by_its_voltage_after_a_while():
    measured = Measured()
    assert measured.see(12.6, for_s=3.0).charging is False
    assert measured.see(13.2, for_s=1.5).charging is False
    state = measured.see(13.2, for_s=2.0)
    assert (state.charging, state.source, state.level, state.charge) == (True, "mains", "ok", None)
    assert measured.see(12.8, for_s=20.0).charging is True
    assert measured.see(12.7, for_s=4.0).charging is True
    assert measured.see(12.7, for_s=3.0).charging is False


def test_one_who_drives_is_not_being_charged_and_a_battery_just_charged_does_not_look_so():
    measured = Measured()
    assert measured.see(13.6, for_s=5.0).charging
    measured.drive(13.5, for_s=1.0)
    assert measured.see(13.4, for_s=1.0).charging is False
    assert measured.see(13.2, for_s=10.0).charging is False
    assert measured.see(13.0, for_s=10.0).charging is False
    assert measured.see(13.3, for_s=5.0).charging is True


def test_a_base_that_slides_sideways_is_not_being_charged():
    """Of four mecanum wheels two go forward and two back, so that neither side has power."""
    measured = Measured()
    assert measured.see(13.6, for_s=5.0).charging
    for count in range(5):
        each = {name: MotorState(power=power, counts=count) for name, power in (("fl", -0.5), ("fr", 0.5))}
        state = measured.see(13.5, for_s=PERIOD_S, motors=each)
    assert state.charging is False


def test_pushing_against_the_contacts_is_not_driving():
    measured = Measured()
    measured.drive(12.5, for_s=1.0)
    still = {"left": -0.1, "right": -0.1, "counts_left": 4, "counts_right": 4}
    assert measured.see(12.5, for_s=1.0, **still).charging is False
    assert measured.see(13.3, for_s=5.0, **still).charging is True


def test_levels_come_and_go_with_a_margin():
    measured = Measured()
    levels = [measured.see(volts, for_s=2.0).level for volts in (12.4, 11.4, 11.52, 11.65, 10.5, 10.8, 10.95, 12.0)]
    assert levels == ["ok", "low", "low", "ok", "critical", "critical", "low", "ok"]


@given(st.lists(st.tuples(st.floats() | st.none(), st.floats(0, 5), st.booleans()), max_size=30))
def test_whatever_is_measured_every_number_shown_is_one(measurements):
    gauge, now = Gauge(KIND.parse("{}")), 0.0
    for voltage_v, pause_s, moving in measurements:
        now += pause_s
        gauge.see(motors(voltage_v, left=0.5 * moving, amps_left_a=voltage_v), now)
        state = gauge.state(now)
        msgspec.json.decode(msgspec.json.encode(state), type=type(state), strict=True)
        assert state.charge is None or 0.0 <= state.charge <= 1.0
        assert state.valid == (state.rest_voltage_v is not None)


@pytest.mark.parametrize(
    ("settings", "complaint"),
    [
        ('{"table": [[12, 0], [11, 1]]}', "both must grow"),
        ('{"table": [[11, 1], [12, 0]]}', "both must grow"),
        ('{"discharging_v": 13}', "above charging_v"),
        ('{"internal_ohms": 1}', "unknown field"),
    ],
)
def test_a_row_that_contradicts_itself_is_refused(settings, complaint):
    with pytest.raises(msgspec.ValidationError, match=complaint):
        KIND.parse(settings)
