"""Scripts of one sender run to their ends: said to a robot that runs, or to one that they start and end."""

from collections.abc import Iterator
from contextlib import ExitStack
from pathlib import Path

import pytest

from tests.support import needs
from tests.support.robot import PATIENT, PATIENT_SERVOS, Robot, lbr, prepare, running
from tests.support.waiting import until

needs.modules("mujoco")

pytestmark = pytest.mark.timeout(180)
ENDS_S = 120.0

LBR = (
    "estop, reset, status",
    "estop, reset, /t/30",
    "reset, /r/0.2/90, s, /t/20",
    "/estop/a ladder, status, why, reset, /r/0.2/270/0/forward/1",
    "/t/20, /t/-20, /r/0.2/90/0/forward/1, /r/0.2/270/0/forward/1",
    "/r/0.2/90, /r/0.2/270, s, status",
    "f, s, b, s, f, b, s",
    "/go/10/0.2, /back/10/0.2, map",
    "/twist/0.1/0/0, s, /twist/0/0/0.3, estop, reset, /twist/0/0/-0.3, s",
    "/behaviour/run/pace, /behaviour/stop, /behaviour/list, mark",
    "/behaviour/run/pace, s, /behaviour/show, /t/15",
    "/behaviour/run/pace, /behaviour/pause, /behaviour/resume, /behaviour/why, s, /t/-15",
    "/record/60, /r/0.3/90/0/forward/1, /record/end, /mark/it turned",
    "/d/metronome, s, /t/10",
    "disable, enable, /t/-10",
    "clock, /report/telemetry, /report/health, /report/events, help, why, /why/drive, qr",
    "s, s, estop, estop, reset, reset, /t/5, S, stop",
)
BIOLOID = (
    "/torque/on, /play/walk_ahead/2, s, /play/sit, picture",
    "estop, reset, status",
    "estop, reset, /torque/on, /play/wave",
    "/torque/on, /j/left_shoulder_pitch/20/90, /j/left_shoulder_pitch/0/90",
    "/torque/on, /j/left_shoulder_pitch/60/10, s, /j/left_shoulder_pitch/0/90",
    "/torque/on, /pose/initial, /play/wave, /mirror/wave",
    "/torque/on, /play/walk/4, /play/wave/1/2",
    "/torque/on, /play/sit, /play/stand_up",
    "/torque/on, /play/wave/5, estop, reset, /torque/on, /play/wave",
    "/torque/on, /behaviour/run/greet, /behaviour/stop, /behaviour/list, mark",
    "/torque/on, /behaviour/run/show, s, /behaviour/show, /play/wave",
    "/torque/on, /behaviour/run/show, /behaviour/pause, /behaviour/resume, /behaviour/why, /behaviour/stop",
    "/torque/on, /torque/off/left_elbow, /torque/on/left_elbow, /j/left_elbow/-10/60",
    "/torque/on, /capture/bow, /j/left_elbow/-20/60, /capture/bow/1, /play/bow",
    "/torque/on, /torque/off/left_elbow, /hand/left_elbow/-40, /hand/off, /torque/on/left_elbow, recover",
    "/record/60, /torque/on, /play/wave, /record/end, /mark/it waved",
    "s, s, estop, estop, reset, reset, /torque/on, S, stop, why, /why/left_knee, help",
)
UXA90 = (
    "estop, reset, status",
    "estop, reset, /torque/on, /j/neck_yaw/20/60",
    "/torque/on, /j/neck_yaw/20/60, /j/neck_yaw/0/60",
    "/torque/on, /j/neck_yaw/60/10, s, /j/neck_yaw/0/60",
    "/estop/the tether is loose, why, status, reset, /torque/on, /j/neck_yaw/10/60",
    "/torque/on, /play/basic_motion, picture",
    "/torque/on, /play/basic_motion, s, /play/basic_motion_down",
    "/play/reset, /play/walk_forward_short, s, status",
    "/torque/on, track, s, look, /j/neck_yaw/0/60",
    "/camera/on, snapshot, /camera/off",
    "pc, /inquire/firmware, /inquire/serial, /inquire/zeros",
    "/behaviour/run/greet, /behaviour/stop, /behaviour/list, mark",
    "/torque/on, /behaviour/run/show, s, /behaviour/show, /j/neck_yaw/5/60",
    "/torque/on, /torque/off/neck_yaw, /torque/on/neck_yaw, /j/neck_yaw/-10/60",
    "/torque/on, /capture/nod, /j/neck_yaw/10/60, /capture/nod/1, /play/nod",
    "/record/60, /torque/on, /j/neck_yaw/10/60, /record/end, /mark/it turned its head",
    "s, s, estop, estop, reset, reset, /torque/on, S, stop, why, /why/left_knee, help",
)
SAID = {"lbr-sim": LBR, "bioloid-sim": BIOLOID, "uxa90-sim": UXA90}
ENDING = {
    "lbr-sim": (
        "estop, reset, /t/30, Shutdown",
        "reset, /r/0.2/90, s, /t/20, Shutdown",
    ),
    "bioloid-sim": (
        "/torque/on, /play/walk_ahead/2, s, /play/sit, picture, Shutdown",
        "estop, reset, /torque/on, /play/wave, Shutdown",
    ),
    "uxa90-sim": (
        "estop, reset, /torque/on, /j/neck_yaw/20/60, Shutdown",
        "/torque/on, /j/neck_yaw/60/10, s, /j/neck_yaw/0/60, look, Shutdown",
    ),
}
"""What is said to a robot as it starts."""


class Running:
    """One robot at a time; another profile's script ends it."""

    def __init__(self, folders: pytest.TempPathFactory) -> None:
        self._folders = folders
        self._stack = ExitStack()
        self._robots: dict[str, Robot] = {}

    def of(self, profile: str) -> Robot:
        """Return the robot of a profile as it ships, at rest and on its feet."""
        if profile not in self._robots:
            self.close()
            home = prepare(self._folders.mktemp("h"), whole=True, edits=(*PATIENT, PATIENT_SERVOS))
            self._robots[profile] = self._stack.enter_context(running(home, profile=profile))
        return at_rest(self._robots[profile])

    def close(self) -> None:
        """End the one that runs."""
        self._robots.clear()
        self._stack.close()


@pytest.fixture(scope="module")
def robots(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Running]:
    robots = Running(tmp_path_factory)
    yield robots
    robots.close()


def at_rest(robot: Robot) -> Robot:
    """Have a robot stand still, on its feet and without an emergency stop."""
    if robot.status()["estop"]["engaged"]:
        robot.line("reset")
    robot.line("stop")
    if robot.name == "bioloid" and not until(lambda: robot.ask("world/pose"), what="its pose")["stands"]:
        robot.line("/torque/off/all")
        until(lambda: limp(robot), what="it is limp")
        robot.line("pick_up")
    return robot


def limp(robot: Robot) -> bool:
    state = robot.ask("joints/state")
    return bool(state) and all(joint["torque"] == 0.0 for joint in state["joints"].values())


def lines(script: str) -> str:
    return "".join(f"{line}\n" for line in script.split(", "))


@pytest.mark.parametrize(("profile", "script"), [(profile, one) for profile, said in SAID.items() for one in said])
def test_a_script_said_to_a_robot_runs_to_its_end(robots: Running, profile: str, script: str) -> None:
    told = lbr(robots.of(profile).home, "console", stdin=lines(script), limit_s=ENDS_S)
    assert (told.returncode, told.stderr) == (0, ""), told.stdout


@pytest.mark.parametrize(("profile", "script"), [(profile, one) for profile, said in ENDING.items() for one in said])
def test_a_script_starts_a_robot_and_ends_it(tmp_path: Path, profile: str, script: str) -> None:
    home = prepare(tmp_path / "h", whole=True, edits=(*PATIENT, PATIENT_SERVOS))
    told = lbr(home, "run", profile, stdin=lines(script), limit_s=ENDS_S)
    assert told.returncode == 0, f"{told.stdout}\n{told.stderr}"
