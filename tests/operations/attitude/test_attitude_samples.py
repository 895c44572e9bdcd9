import os
from datetime import datetime, timedelta

import pytest

from lbr.errors import InputError
from lbr.messages.imu import ImuSample
from lbr.operations.attitude import samples
from lbr.operations.attitude.samples import Samples, load, save

UP = (0.0, 0.0, 9.81)
BEGAN = datetime(2025, 1, 1, 12).astimezone()


@pytest.fixture
def collected():
    found = Samples()
    found.take(ImuSample(valid=True, time_s=1.0, accel_mps2=UP, mag_ut=(1.0, 2.0, 3.0)), 0.0, 0.05)
    return found


def test_the_oldest_files_of_calibrations_go_and_those_of_people_stay(tmp_path, collected, monkeypatch):
    monkeypatch.setattr(samples, "MOST_KEPT", 3)
    folder = tmp_path / "calibration"
    folder.mkdir()
    (folder / "mag-mine.csv").write_text("x,y,z\n")
    for second in range(6):
        save(str(tmp_path), collected, BEGAN + timedelta(seconds=second)).with_suffix(".png").write_bytes(b"")
    kept = [f"mag-20250101-12000{second}.{end}" for second in (3, 4, 5) for end in ("csv", "png")]
    assert sorted(path.name for path in folder.iterdir()) == [*kept, "mag-mine.csv"]


def test_a_file_from_a_clock_that_was_set_back_is_kept(tmp_path, collected, monkeypatch):
    monkeypatch.setattr(samples, "MOST_KEPT", 1)
    save(str(tmp_path), collected, BEGAN)
    assert save(str(tmp_path), collected, BEGAN - timedelta(days=1)).is_file()


def test_what_is_no_file_is_not_waited_for(tmp_path):
    folder = tmp_path / "calibration"
    folder.mkdir()
    os.mkfifo(folder / "pipe.csv")
    with pytest.raises(InputError, match="is not a file"):
        load(str(tmp_path), "pipe.csv", UP)


@pytest.mark.parametrize("number", ["nan", "inf", "1e300", "-1e7"])
def test_numbers_that_no_sensor_measures_are_refused_with_their_line(tmp_path, number):
    folder = tmp_path / "calibration"
    folder.mkdir()
    (folder / "mine.csv").write_text(f"x,y,z\n1,2,3\n1,{number},3\n")
    with pytest.raises(InputError, match=r"mine\.csv, line 3: .*far too large"):
        load(str(tmp_path), "mine.csv", UP)
