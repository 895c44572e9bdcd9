"""The compass's calibration: turning, collecting, fitting, keeping; and every way in which it ends early."""

import csv
from math import sqrt
from pathlib import Path
from threading import Event, Thread

import numpy as np
import pytest

from lbr.messages.attitude import CalibrateCommand
from lbr.operations.attitude.samples import HEADER
from lbr.operations.attitude.settings import Mounting
from tests.operations.attitude.attitude_context import AttitudeContext
from tests.operations.attitude.imu_bench import MadeUpImu, about, apart_deg
from tests.support.waiting import until

IRON = about(2, 0.5) @ np.diag((1.2, 0.85, 1.0)) @ about(2, -0.5)


def ended(bench):
    return lambda: bench.said("calibration") and bench.said("calibration")[-1].phase in {"done", "refused"}


def last(bench):
    return bench.said("calibration")[-1]


def answered(bench, call):
    """The answer about a file, which waits for the import of what fits."""
    return until(lambda: bench.run(0.02) or call.answer)


def rms_of_heading(bench, seconds=8.0):
    errors = []
    for _ in range(round(seconds * 50)):
        bench.drive.lease, bench.drive.power, bench.drive.until_s = "x", 0.15, bench.clock() + 1.0
        bench.run(0.02)
        errors.append(apart_deg(bench.state().heading_deg, bench.imu.heading_deg))
    return sqrt(sum(e * e for e in errors) / len(errors))


@pytest.mark.parametrize(
    ("tilt_deg", "mounting", "matrix"),
    [
        (0.0, Mounting(), np.eye(3)),
        (3.0, Mounting(roll_deg=180.0, yaw_deg=40.0), about(2, np.radians(40.0)) @ about(0, np.pi)),
    ],
)
def test_after_a_turn_on_the_spot_the_heading_is_within_a_degree(tmp_path, tilt_deg, mounting, matrix):
    imu = MadeUpImu(
        bias_dps=(0.5, -0.7, 0.8),
        hard_iron_ut=(-34.5, 8.4, 10.0),
        soft_iron=IRON,
        sensor_in_body=matrix,
        pitch_deg=tilt_deg,
        mag_every=2,
    )
    bench = AttitudeContext(tmp_path, imu, mounting=mounting)
    bench.run(1.5)
    call = bench.calibrate(150)
    bench.run(20.0, ended(bench))
    assert call.answer.accepted
    assert last(bench).phase == "done", last(bench).text
    assert last(bench).residual < 0.03
    assert last(bench).coverage == 1.0
    assert bench.state().calibrated
    bench.run(0.5)
    assert bench.drive.rate_dps(bench.clock()) == 0.0
    assert rms_of_heading(bench) < 1.0


def test_the_turn_is_slow_on_the_spot_clockwise_and_renewed_by_its_lease(bench):
    bench.calibrate(100)
    bench.run(20.0, ended(bench))
    times = [when for when, _ in bench.drive.commands]
    commands = [command for _, command in bench.drive.commands]
    assert {(c.power, c.angle_deg, c.take_over) for c in commands} == {(0.2, 90.0, False)}
    assert commands[0].lease == ""
    assert {c.lease for c in commands[1:]} == {"lease-1"}
    assert max(np.diff(times)) < 0.13
    assert len(bench.drive.stops) == 1


def test_what_is_found_is_kept_and_told_and_written_down(bench, tmp_path):
    call = bench.calibrate(100)
    bench.run(20.0, ended(bench))
    assert call.answer.accepted
    (kept,) = bench.kept
    assert [kept[f"mag_offset_{axis}_ut"] for axis in "xy"] == pytest.approx([12.0, -9.0], abs=0.4)
    assert kept["mag_offset_z_ut"] == pytest.approx(0.0, abs=0.3)
    assert {f"mag_matrix_{r}{c}" for r in range(3) for c in range(3)} < set(kept)
    assert kept["mag_horizontal_ut"] == pytest.approx(19.0, abs=0.5)
    assert "hard iron" in bench.told("calibrated")[0]
    phases = [progress.phase for progress in bench.said("calibration")]
    assert phases[0] == "collecting"
    assert phases[-3:] == ["fitting", "done", "done"]  # and what the picture is
    (file,) = (tmp_path / "calibration").glob("mag-*.csv")
    rows = list(csv.reader(file.read_text().splitlines()))
    assert tuple(rows[0]) == HEADER
    assert len(rows) - 1 == last(bench).collected >= 100
    assert last(bench).picture == str(file.with_suffix(".svg"))
    assert file.with_suffix(".svg").read_text().count("<circle") == 2 * last(bench).collected


def test_a_calibration_is_told_only_once_a_heading_by_it_was_published(bench):
    """Who hears that it is done may turn to a heading at once."""
    bench.calibrate(100)
    bench.run(20.0, lambda: bench.kept)
    assert bench.told("calibrated") == []
    bench.run(3.0, lambda: bench.told("calibrated"))
    (told,) = bench.told("calibrated")
    assert "not known yet" not in told
    assert (bench.state().calibrated, bench.state().heading_deg is not None) == (True, True)


def test_a_calibration_without_a_heading_after_it_says_why(bench):
    bench.calibrate(100)
    bench.run(20.0, lambda: bench.kept)
    bench.imu.mag_every = 10**9
    bench.run(3.0, lambda: bench.told("calibrated"))
    (told,) = bench.told("calibrated")
    assert "heading is not known" in told


def test_a_contradiction_of_the_old_calibration_is_not_held_against_the_new_one(bench):
    bench.run(1.0)
    fusion = bench.capability._fusion
    fusion._field_trouble = "it contradicts the gyro"
    fusion.calibrate(bench.calibration)
    assert "has not measured" in fusion.state(bench.clock()).heading_reason


def test_few_samples_go_on_until_the_turn_is_whole(bench):
    bench.calibrate(50)
    bench.run(20.0, ended(bench))
    assert last(bench).phase == "done"
    assert last(bench).collected > 65


def test_a_long_collection_turns_back_before_the_drive_would_end_it(tmp_path):
    bench = AttitudeContext(tmp_path, reverse_s=3.0, sample_s=0.1)
    bench.run(1.5)
    bench.calibrate(80)
    bench.run(20.0, ended(bench))
    assert {command.angle_deg for _, command in bench.drive.commands} == {90.0, 270.0}
    assert bench.drive.leases == 1


def test_just_looking_keeps_nothing(bench):
    bench.calibrate(100, "-c")
    bench.run(20.0, ended(bench))
    assert last(bench).phase == "done"
    assert bench.kept == []
    assert bench.told("calibrated") == []
    assert Path(last(bench).picture).read_text().count("<circle") >= 2 * 100


def test_a_file_is_fitted_without_any_motion(bench, tmp_path):
    bench.calibrate(100)
    bench.run(20.0, ended(bench))
    first = bench.kept.pop()
    commands = len(bench.drive.commands)
    (file,) = (tmp_path / "calibration").glob("mag-*.csv")
    answer = answered(bench, bench.calibrate(2000, file.name))
    assert answer.accepted
    assert "hard iron" in answer.reason
    assert bench.kept[0] == pytest.approx(first, abs=0.01)
    assert len(bench.drive.commands) == commands


@pytest.mark.parametrize("name", ["../robot.db", "/etc/passwd", "a/b.csv", "..", "", "-x", "link.csv", "nul\0"])
def test_no_source_leads_out_of_the_folder(bench, tmp_path, name):
    folder = tmp_path / "calibration"
    folder.mkdir(exist_ok=True)
    (tmp_path / "elsewhere.csv").write_text("x,y,z\n1,2,3\n")
    (folder / "link.csv").symlink_to(tmp_path / "elsewhere.csv")
    answer = bench.calibrate(100, name).answer
    assert not answer.accepted
    assert "a source is" in answer.reason


@pytest.mark.parametrize(
    ("content", "reason"),
    [
        ("", "empty"),
        ("a,b\n1,2\n", "no columns"),
        ("x,y,z\n1,2\n", "line 2"),
        ("x,y,z\n1,2,nan\n", "line 2"),
        ("x,y,z\n1,2,three\n", "three"),
        ("x,y,z\n" + "1,2,3\n" * 10, "too few"),
        ("x,y,z\n" + "1,2,3\n" * 100, "hardly changed"),
    ],
)
def test_a_file_that_is_no_collection_is_refused_with_the_line(bench, tmp_path, content, reason):
    folder = tmp_path / "calibration"
    folder.mkdir(exist_ok=True)
    (folder / "mine.csv").write_text(content)
    answer = answered(bench, bench.calibrate(100, "mine.csv"))
    assert not answer.accepted
    assert reason in answer.reason
    assert bench.kept == []


def test_a_file_is_not_fitted_if_a_stop_comes_first(bench, tmp_path):
    (tmp_path / "calibration").mkdir(exist_ok=True)
    (tmp_path / "calibration" / "mine.csv").write_text("x,y,z\n" + "1,2,3\n" * 100)
    imported = Event()
    bench.capability._calibration._loading = Thread(target=imported.wait)
    call = bench.calibrate(100, "mine.csv")
    bench.run(0.1)
    assert "already" in bench.calibrate(500).answer.reason
    assert bench.stop().answer.accepted
    imported.set()
    bench.run(0.1)
    assert call.answer.code == "stopped"
    assert bench.said("calibration") == []


def test_a_missing_file_is_told_with_those_that_there_are(bench):
    assert "/m/300/-" in bench.calibrate(100, "none.csv").answer.reason


def test_a_drive_that_refuses_is_quoted_and_nothing_is_collected(bench):
    bench.drive.refuses = "held by console"
    call = bench.calibrate()
    bench.run(0.1)
    assert call.answer.reason == "held by console"
    assert last(bench).phase == "refused"
    assert bench.drive.stops == []


@pytest.mark.parametrize(("fault", "reason"), [("mute", "does not answer"), ("absent", "must be wired to one drive")])
def test_a_drive_that_is_not_there_is_told(bench, fault, reason):
    setattr(bench.drive, fault, True)
    call = bench.calibrate()
    bench.run(2.0)
    assert reason in call.answer.reason


def test_a_dead_lease_ends_it_with_the_drives_reason_and_stops_nobody_else(bench, tmp_path):
    bench.calibrate(500)
    bench.run(1.0)
    bench.drive.lease = "somebody else's"
    bench.run(0.3)
    assert last(bench).phase == "refused"
    assert last(bench).text == "stopped by console"
    assert bench.drive.stops == []
    assert list((tmp_path / "calibration").glob("mag-*.csv"))


def test_a_stop_ends_it_and_halts(bench, wording):
    bench.calibrate(500)
    bench.run(1.0)
    assert bench.stop().answer.accepted
    assert len(bench.drive.stops) == 1
    commands = len(bench.drive.commands)
    bench.run(1.0)
    assert len(bench.drive.commands) == commands
    assert "stopped by console" in last(bench).text
    assert bench.kept == []
    wording(bench.stop().answer)
    assert bench.stop(whole=True).answer.reason == ""


def test_closing_halts(bench):
    bench.calibrate(500)
    bench.run(1.0)
    bench.capability.close()
    assert len(bench.drive.stops) == 1


def test_only_one_at_a_time(bench):
    bench.calibrate(500)
    bench.run(0.5)
    assert "already" in bench.calibrate(500).answer.reason
    assert "already" in bench.calibrate(500, "x.csv").answer.reason


def test_samples_that_stop_coming_end_it_and_halt(bench):
    bench.calibrate(500)
    bench.run(1.0)
    bench.deaf = True
    bench.run(0.5)
    assert len(bench.drive.stops) == 1
    assert "no sample" in last(bench).text


def test_it_does_not_begin_while_the_attitude_is_unknown(bench):
    bench.deaf = True
    bench.run(1.0)
    assert "no sample" in bench.calibrate().answer.reason
    assert bench.drive.commands == []


def test_a_robot_that_does_not_turn_is_noticed(bench):
    bench.drive.rate_dps = lambda now: 0.0
    bench.calibrate(500)
    bench.run(5.0, ended(bench))
    assert "does not turn" in last(bench).text
    assert len(bench.drive.stops) == 1


def test_a_compass_that_falls_silent_ends_it_before_long(bench, wording):
    bench.calibrate(300)
    bench.run(2.0)
    assert last(bench).phase == "collecting"
    bench.imu.mag_every = 10**9
    began = bench.clock()
    bench.run(20.0, ended(bench))
    assert bench.clock() - began < 4.0
    assert last(bench).phase == "refused"
    wording(last(bench).text)
    assert len(bench.drive.stops) == 1


def test_it_ends_after_its_time(tmp_path):
    bench = AttitudeContext(tmp_path, calibration_limit_s=3.0)
    bench.run(1.5)
    bench.calibrate(2000)
    bench.run(5.0, ended(bench))
    assert "within 3 s" in last(bench).text
    assert len(bench.drive.stops) == 1


def test_a_compass_without_iron_around_needs_hardly_a_correction(tmp_path):
    bench = AttitudeContext(tmp_path)
    bench.run(1.5)
    bench.say("calibrate", CalibrateCommand(samples=100))
    bench.run(20.0, ended(bench))
    (kept,) = bench.kept
    assert [kept[f"mag_matrix_{i}{i}"] for i in range(3)] == pytest.approx([1.0, 1.0, 1.0], abs=0.03)
