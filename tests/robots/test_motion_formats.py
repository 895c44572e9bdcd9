"""Motion files of robots' makers: a robot's package has them read, by the suffix of their names."""

import pytest

from lbr.apps.motions.commands import motion_files
from lbr.errors import InputError
from lbr.robot import registry
from tests.support.packages import DECLARED, imported_from, robot_package

READER = """
from lbr.messages.joints import KeyFrame, Motion
from lbr.robot.motion_file import MotionFormat

class Dance:
    def __init__(self, content):
        self.content = content

    def fits(self, rows):
        return True

    def motions(self, rows):
        return (Motion(name="dance", frames=(KeyFrame(positions=dict(), duration_s=1.0),)),), [self.content.decode()]
"""
FORMAT = 'MotionFormat(suffix="{suffix}", summary="a dance", read="my_crawler:Dance")'


def declared(formats: str) -> str:
    return READER + DECLARED.replace('summary="a', f'motion_formats=({formats},), summary="a')


def test_a_package_has_its_makers_files_read(tmp_path):
    robot_package(tmp_path, declared=declared(FORMAT.replace("{suffix}", ".moves")))
    with imported_from(tmp_path):
        found = motion_files.read(b"one, two", ".MOVES")
        assert not isinstance(found, motion_files.MotionFile)
        (motion,), notes = found.motions(None)
        assert (motion.name, notes) == ("dance", ["one, two"])
        with pytest.raises(InputError, match=r"it is not a motion: .*\.moves \(a dance\), \.mtn .*, \.rbm"):
            motion_files.read(b"one, two", ".txt")
        with pytest.raises(InputError, match=r"\.moves \(a dance\) are read here, not written"):
            motion_files.exported("crawler", motion, None, ".moves")
    assert ".moves" not in registry.motion_formats()


def test_lbrs_own_format_stays_its_own(tmp_path):
    robot_package(tmp_path, declared=declared(FORMAT.replace("{suffix}", ".rbm")))
    with imported_from(tmp_path):
        assert registry.motion_formats()[".rbm"].read.startswith("lbr.robots.uxa90")


@pytest.mark.parametrize("formats", [FORMAT.replace("{suffix}", one) for one in ("moves", ".json", ".A B", "")] + ["3"])
def test_a_format_that_is_none_refuses_the_robot_in_words(tmp_path, formats):
    robot_package(tmp_path, declared=declared(formats))
    with imported_from(tmp_path):
        found = registry.find("crawler")
        assert found is not None
        assert found.robot is None
        assert "'motion_formats' has" in found.fault


def test_a_file_that_is_too_large_is_refused_whatever_it_is(wording):
    with wording.of(InputError):
        motion_files.read(b" " * ((4 << 20) + 1), ".rbm")
