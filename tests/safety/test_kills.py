"""Whatever process is killed while the robot drives, the motors stand and stay so."""

from tests.safety.limits import holds
from tests.scenarios import kills


def test_a_killed_motor_driver_leaves_the_motors_standing():
    results = holds(lambda results: kills.kill_motor_driver(results, 2))
    assert results.of("S1").n == 2
    assert results.of("S14").n >= 2


def test_killed_drive_operations_leave_the_motors_standing():
    assert holds(lambda results: kills.kill_drive(results, 2)).of("S3").n == 2


def test_drive_operations_with_a_process_of_their_own_leave_the_motors_standing():
    results = holds(lambda results: kills.hurt_drive_apart(results, 2))
    assert (results.of("S3").n, results.of("S4").n) == (2, 1)


def test_a_killed_executive_leaves_the_motors_standing_and_no_process():
    results = holds(lambda results: kills.kill_executive(results, 2))
    assert results.of("S6").n == 2
    assert results.of("S6 gone").n == 2
