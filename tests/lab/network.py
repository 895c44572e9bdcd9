"""Two machines and a cable between them: the robot's, and an operator's that reads its ranges, dances with it and drives it.

Both come from the one that was built, each with a name, addresses, a home and a start of its own. The robot's motor controller is
played to one kernel and its range board to the other. What is cut, frozen or killed is, from outside; each time is by the clock
of the robot's machine, unless the scene says otherwise.
"""

import json
import shutil
import subprocess
import time
from collections.abc import Callable, Generator, Iterator, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

from tests.lab import abreast, processor, stage
from tests.lab.abreast import Abreast
from tests.lab.machine import Machine
from tests.lab.stage import AS_SERVICE, PLAYED, WAIT_S, Scene, SceneError, Stage, until, within
from tests.support import programs
from tests.support.robot import free_port

KEPT = "network.json"
MOST_APART_S = 0.25
"""How far one clock may ever be ahead: streams between machines are judged by clocks that are as fast as one another, and a
reading of 0.3 s is too old (docs/two_machines.md)."""
APART = "apart"
UNIT, AGENT = "lbr@two.service", "lbr-agent.service"
ADDRESSES = {"robot": "10.9.0.1", "operator": "10.9.0.2"}
DOOR = f"tls/{ADDRESSES['robot']}:7447"
PROFILE = """robot = "lbr"
simulate = false
plugged_in_elsewhere = ["ranges"]

[hosts]
operator = ["ranges", "dance"]
"""
CABLE_UNIT = """[Unit]
Before=network.target
[Service]
Type=oneshot
RemainAfterExit=yes
ExecStart=/bin/sh -c 'until ip link show eth1; do sleep 1; done; ip address add {}/24 dev eth1; ip link set eth1 up'
[Install]
WantedBy=multi-user.target
"""
AGENT_UNIT = f"""[Unit]
Description=a share of the robot
After=network.target lab-player.service
[Service]
User=lbr
Environment=LBR_HOME=/var/lib/lbr PYTHONUNBUFFERED=1
ExecStart=/opt/lbr/bin/lbr agent operator --connect {DOOR} --token-file /var/lib/lbr/operator.token
LimitNICE=-15
Restart=always
RestartSec=3
[Install]
WantedBy=multi-user.target
"""
FROM_AFAR = f"LBR_HOME=/root/lbr LBR_TOKEN={{}} /opt/lbr/bin/lbr send --connect {DOOR} {{}}"
CLIENT = "cd /opt/lab && exec /opt/lbr/bin/python tests/support/clients/at_a_door.py /root/phone.json5 quoting"
FINDING = """
import json, time
from lbr import client

began, found = time.monotonic(), []
while not found and time.monotonic() < began + 20.0:
    found = [one for one in client.find(within_s=1.5) if one.door]
print(json.dumps([time.monotonic() - began, found]))
"""
CLIENT_ZERO_S = 0.5
"""A lease is 0.3 s; the rest is its last renewal, the drive's period and the controller's answer."""
TOLD_S = 1.5
"""A link that stalls for 0.4 s is given up."""
RAMP_S = 0.5
STANDS_S, FROZEN_S = 1.0, 5.0
Send = Callable[[Machine], None]


def play(folder: Path, send: Send, words: Sequence[str] = ()) -> Generator[Scene]:
    """Try it all, or what is told with one of these words, one after the other; one that fails is followed by rest."""
    with Two.started(folder, send) as two:
        for what, scene in (
            ("the operator's machine finds the robot by zeroconf", two.found),
            ("who has a token drives from there; without one, or with a stranger's, nobody does", two.tokens),
            ("the robot's ranges are read there, and it drives by them", two.shared),
            ("the cable is cut while a client there drives", two.client_cut),
            ("the cable is cut behind a switch while a client there drives", two.client_cut_behind_a_switch),
            ("the cable is cut while the robot dances from there", two.dance_cut),
            ("the cable is cut while the robot drives by the ranges from there", two.ranges_cut),
            ("that machine is frozen for 5 s while a client there drives", two.client_frozen),
            ("that machine is frozen for 5 s while the robot dances from there", two.dance_frozen),
            ("that machine's clock is a year behind, and jumps two years ahead in motion", two.operator_clock),
            ("the robot's clock is set back by an hour in motion", two.robot_clock),
            ("that machine loses its power while the robot dances from there, and starts again", two.killed),
        ):
            if not words or any(one in what for one in words):
                seen = stage.tell(what, scene)
                yield seen
                if not seen.passed:
                    with suppress(Exception):
                        two.rest()
        yield stage.tell("the two clocks, all the while", two.apart)


class Two:
    """The robot's machine and the operator's."""

    def __init__(self, robot: Stage, operator: Stage) -> None:
        self.robot = robot
        self.operator = operator
        self._token = (operator.machine.folder.parent / "phone.token").read_text().strip()
        self._abreast = Abreast(robot.machine.clock, operator.machine.clock)

    @classmethod
    @contextmanager
    def started(cls, folder: Path, send: Send) -> Iterator["Two"]:
        """Have both run, joined; they are made first if they were not since the machine was built."""
        port = free_port()
        stages: list[Stage] = []
        try:
            for name, cable in (("robot", "listen"), ("operator", "connect")):
                own = folder / name
                if not _is_made(folder, own):
                    _make(folder, own, send)
                machine = Machine(own, cable=f"{cable}=127.0.0.1:{port}")
                stages.append(Stage(machine, send, UNIT))
            for one in stages:
                one.machine.start(snapshot=True, named=APART)
            two = cls(*stages)
            two._abreast.start()
            try:
                two.shares()
                yield two
            finally:
                two._abreast.stop()
        finally:
            for one in stages:
                one.machine.cut()

    # -- scenes -------------------------------------------------------------------------------------------------

    def found(self) -> str:
        """Look for robots as a program does."""
        took_s, found = json.loads(self._at_operator(f'/opt/lbr/bin/python -c "{FINDING}"'))
        robot, host, door, page = found[0]
        if (robot, host, door) != ("lbr", ADDRESSES["robot"], DOOR):
            raise SceneError(f"found {found}")
        return f"{door} and {page} after {took_s:.1f} s"

    def tokens(self) -> str:
        """Say lines from there, with a token and without."""
        said = self._at_operator(FROM_AFAR.format(self._token, "--hold 1 /r/0.3/90"))
        if not any(left for _at, left, _right in self.robot.outputs()):
            raise SceneError(f"it did not drive: {said}")
        until(lambda: not self.robot.moving(), "zero")
        name, secret, fingerprint = self._token.split(".")
        moves = len(self.robot.outputs())
        refused = []
        for who, token in (
            ("none", ""),
            ("another's secret", f"{name}.{'A' * len(secret)}.{fingerprint}"),
            ("an unknown name", f"stranger.{secret}.{fingerprint}"),
            ("another robot's", f"{name}.{secret}.{'A' * len(fingerprint)}"),
        ):
            words = FROM_AFAR.format(token, "/r/0.3/90").replace("LBR_TOKEN= ", "")
            done = self.operator.machine.run(words, check=False, limit_s=WAIT_S)
            if done.returncode == 0:
                raise SceneError(f"{who}: was let in")
            refused.append(f"{who}: '{done.stderr.decode().strip()[:90]}'")
        if len(self.robot.outputs()) != moves:
            raise SceneError("the motors got something by a wrong token")
        return f"'{said.splitlines()[0]}'; refused with {'; '.join(refused)}"

    def shared(self) -> str:
        """Drive ahead at the robot, which the ranges that are read elsewhere allow."""
        boots = {self._boot(one) for one in (self.robot, self.operator)}
        if len(boots) != 2:
            raise SceneError("the machines have one start")
        with self._drives_here("/r/0.3/0"):
            at = self.robot.now()
            self.robot.machine.run("sleep 3")
            if zeros := [one for one in self.robot.outputs() if one[0] > at and one[1:] == (0.0, 0.0)]:
                raise SceneError(f"it stood still {len(zeros)} times")
        power = max(abs(left) for _at, left, _right in self.robot.outputs())
        return f"went on ahead for 3 s at up to {power:g}; {self._phases()}"

    def client_cut(self) -> str:
        """Cut the cable, both ends of it, while a client drives."""
        with self._drives_from_afar():
            at = self._cut()
            zero_s = self._stands_after(at)
            self._heal()
            self.robot.still()
        return f"zero after {zero_s * 1e3:.0f} ms; in again, nothing resumed; {self._drives_again()}"

    def client_cut_behind_a_switch(self) -> str:
        """Cut the cable at the operator's end alone: the robot's card still has its carrier."""
        with self._drives_from_afar():
            at = self.robot.now()
            self.operator.machine.plug(there=False)
            zero_s = self._stands_after(at)
            self.operator.machine.plug(there=True)
            self.robot.still()
        return f"zero after {zero_s * 1e3:.0f} ms; in again, nothing resumed; {self._drives_again()}"

    def dance_cut(self) -> str:
        """Cut the cable while an app there moves the robot."""
        self._dances()
        at = self._cut()
        zero_s = self._stands_after(at)
        told_s = self._told_after(at)
        gone_s = self._ended_after(self.operator.last("cable 0"))
        self._heal()
        back_s = self._back_after(self.robot.last("cable 1"))
        self.robot.still()
        self._dances()
        self._stops()
        return (
            f"zero after {zero_s * 1e3:.0f} ms, told after {told_s:.2f} s; there, by its own clock, the agent ended its share after "
            f"{gone_s:.2f} s; in again, ready after {back_s:.1f} s, nothing resumed; dances when told to"
        )

    def ranges_cut(self) -> str:
        """Cut the cable while the robot drives ahead, held by somebody at the robot."""
        with self._drives_here("/r/0.3/0"):
            zero_s = self._stands_after(self._cut())
            self._heal()
            self.shares()
            held = "goes on with the motion that is held" if self.robot.moving() else "stands"
        until(lambda: not self.robot.moving(), "at rest")
        with self._drives_here("/r/0.3/0"):
            pass
        return f"zero after {zero_s * 1e3:.0f} ms; in again, it {held}, and drives when told to"

    def client_frozen(self) -> str:
        """Freeze the operator's machine, and let it go on as if no time had passed."""
        with self._drives_from_afar():
            zero_s = self._freeze()
            self.robot.still()
        return f"zero after {zero_s * 1e3:.0f} ms; it went on, and what was held back moved nothing; {self._drives_again()}"

    def dance_frozen(self) -> str:
        """Freeze it while an app there moves the robot.

        Its clock stands still meanwhile, so what comes from there looks as late as that, until it is compared anew.
        """
        self._dances()
        zero_s = self._freeze()
        at = self.robot.now()
        self.shares()
        self.robot.still()
        self._dances()
        again_s = next(one[0] for one in self.robot.outputs() if one[0] > at and one[1:] != (0.0, 0.0)) - at
        self._stops()
        return f"zero after {zero_s * 1e3:.0f} ms; it went on, and nothing resumed; dances when told to, {again_s:.0f} s later"

    def operator_clock(self) -> str:
        """Set the operator's clock back before anything of it comes in, and forth while it drives and dances."""
        machine = self.operator.machine
        machine.run(f"systemctl stop {AGENT} && date -s '1 year ago' && systemctl start {AGENT}", limit_s=WAIT_S)
        self.shares()
        with self._drives_from_afar():
            at = self.robot.now()
            machine.run("date -s '2 years'")
            self.robot.machine.run("sleep 2")
            if any(one[1:] == (0.0, 0.0) for one in self.robot.outputs() if one[0] > at):
                raise SceneError("the client's motion was interrupted")
            self._at_operator(FROM_AFAR.format(self._token, "stop"))
            self.robot.still()
        self._dances()
        at = self.robot.now()
        machine.run("date -s '1 year ago'")
        self.robot.machine.run("sleep 2")
        if not [one for one in self.robot.outputs() if one[0] > at + 1.0]:
            raise SceneError("it dances no more")
        self._stops()
        return "came in a year behind; a client went on and was stopped from there, the dance went on and was stopped"

    def robot_clock(self) -> str:
        """Set the robot's clock back while it drives."""
        machine = self.robot.machine
        with self._drives_from_afar():
            at = self.robot.now()
            machine.run("date -s '1 hour ago'")
            machine.run("sleep 2")
            if any(one[1:] == (0.0, 0.0) for one in self.robot.outputs() if one[0] > at):
                raise SceneError("the motion was interrupted")
            at = self.robot.now()
            self.operator.machine.run("pkill -KILL -f at_a_door")
            lapsed_s = self.robot.zero_after(at)
        again = self._drives_again()
        if others := {name: one["phase"] for name, one in self.robot.capabilities().items() if one["phase"] != "ready"}:
            raise SceneError(f"not ready: {others}")
        machine.run(f"{AS_SERVICE} db audit", limit_s=WAIT_S)
        jumped = [one["text"] for one in self._reported() if one["kind"] == "clock_jumped"][-1]
        machine.run(f"date -s @{int(time.time())}")
        return (
            f"went on; its client killed, zero within {lapsed_s * 1e3:.0f} ms; {again}; all is ready, the audit trail is whole, and the "
            f"black box tells: {jumped}"
        )

    def killed(self) -> str:
        """Kill the operator's machine, start it, and wait until its agent has come back by itself."""
        self._dances()
        at = self.robot.now()
        with self._abreast.alone():
            self.operator.machine.cut()
            try:
                zero_s = self._stands_after(at)
                told_s = self._told_after(at)
                alone = self.robot.machine.run(f"{AS_SERVICE} send --hold 1 /r/0.3/0", check=False, limit_s=WAIT_S)
                if alone.returncode == 0 or self.robot.moving():
                    raise SceneError("it drives without ranges")
            finally:
                self.operator.machine.start(snapshot=False)
        self.shares()
        self.robot.still()
        self._dances()
        self._stops()
        return (
            f"zero after {zero_s * 1e3:.0f} ms, told after {told_s:.2f} s; the robot refuses to drive: '{alone.stderr.decode().strip()}'; "
            "that machine started, its agent came by itself, nothing resumed; dances when told to"
        )

    def apart(self) -> str:
        """Tell how evenly the machines' clocks went: they are to be two clocks, as fast as one another."""
        if (apart_s := self._abreast.seen()) > MOST_APART_S:
            raise SceneError(f"one was {apart_s:.2f} s ahead: what streams did here proves nothing")
        return f"one was never more than {apart_s * 1e3:.0f} ms ahead of the other"

    # -- what scenes are made of --------------------------------------------------------------------------------

    def shares(self) -> None:
        """Wait until what is placed on the operator's machine is ready."""
        until(lambda: all(self._phase(name) == "ready" for name in ("ranges", "dance")), "the share is ready")

    def rest(self) -> None:
        """Have nothing and nobody move the robot, and the cable in."""
        self.operator.machine.run("pkill -KILL -f 'at_a_door'", check=False)
        self.robot.machine.run("pkill -KILL -f 'lbr send'", check=False)
        self.robot.machine.run(f"{AS_SERVICE} send stop", check=False, limit_s=WAIT_S)
        for one in (self.robot, self.operator):
            one.machine.plug(there=True)
        until(lambda: not self.robot.moving(), "at rest")
        self.shares()

    @contextmanager
    def _drives_from_afar(self) -> Iterator[None]:
        """Have a client on the operator's machine drive, by nothing but Zenoh and a lease that it quotes for ever."""
        client = programs.start(
            [*self.operator.machine.ssh(), CLIENT], stdin=subprocess.PIPE, stdout=subprocess.DEVNULL
        )
        try:
            self._at_speed()
            yield
        finally:
            self.operator.machine.run("pkill -KILL -f at_a_door", check=False)
            client.kill()
            client.wait()
            assert client.stdin is not None
            client.stdin.close()

    @contextmanager
    def _drives_here(self, line: str) -> Iterator[None]:
        """Have somebody at the robot hold a motion."""
        self.robot.machine.run(f"({AS_SERVICE} send --hold 30 {line}) >/tmp/drives 2>&1 </dev/null &")
        try:
            self._at_speed()
            yield
        finally:
            self.robot.machine.run("pkill -KILL -f 'lbr send'", check=False)

    def _at_speed(self) -> None:
        until(self.robot.moving, "motion")
        self.robot.machine.run(f"sleep {RAMP_S:g}")

    def _dances(self) -> None:
        """Have the robot dance, which the operator's machine does."""
        self.shares()
        until(lambda: not self.robot.moving(), "at rest")
        words = f"({AS_SERVICE} send /d/metronome) || {{ sleep 10; false; }}"  # at rest, both clocks are as fast
        until(lambda: self.robot.machine.run(words, check=False, limit_s=WAIT_S).returncode == 0, "it may dance")
        until(self.robot.moving, "it dances")

    def _stops(self) -> None:
        """Stop it at the robot."""
        self.robot.machine.run(f"{AS_SERVICE} send stop", limit_s=WAIT_S)
        self.robot.still()

    def _drives_again(self) -> str:
        """Drive from the operator's machine, by a new command."""
        with self._drives_from_afar():
            pass
        until(lambda: not self.robot.moving(), "at rest")
        return "the next command drives"

    def _cut(self) -> float:
        """Pull the cable; return when the robot's kernel noticed."""
        before = len(self.robot.said("cable 0"))
        for one in (self.robot, self.operator):
            one.machine.plug(there=False)
        until(lambda: len(self.robot.said("cable 0")) > before, "the cable out")
        return self.robot.last("cable 0")

    def _heal(self) -> None:
        before = len(self.robot.said("cable 1"))
        for one in (self.robot, self.operator):
            one.machine.plug(there=True)
        until(lambda: len(self.robot.said("cable 1")) > before, "the cable in")

    def _stands_after(self, at: float) -> float:
        """Return how long after a moment the motors got zero, and then nothing else for a while; as long as is promised."""
        self.robot.machine.run(f"sleep {STANDS_S:g}", limit_s=WAIT_S)
        if self.robot.moving():
            raise SceneError(f"it moves on, {STANDS_S:g} s later")
        return within(max(0.0, self.robot.outputs()[-1][0] - at), CLIENT_ZERO_S)

    def _freeze(self) -> float:
        """Freeze the operator's machine for some seconds of the robot's; return after how long the motors got zero."""
        with self._abreast.alone():
            at = self.robot.now()
            self.operator.machine.monitor("stop")
            try:
                zero_s = self._stands_after(at)
                self.robot.machine.run(f"sleep {FROZEN_S - STANDS_S:g}")
            finally:
                self.operator.machine.monitor("cont")
        return zero_s

    def _told_after(self, at: float) -> float:
        """Return how long after a moment the robot told that the host is gone."""
        told = until(lambda: [one for one in self._events("host_lost") if one > at], "told")[0] - at
        if not told <= TOLD_S:
            raise SceneError(f"told after {told:.2f} s, {TOLD_S:g} s is promised")
        return told

    def _back_after(self, at: float) -> float:
        """Return how long after a moment the host's last capability was ready."""
        self.shares()
        return max(one for one in self._events("started", "recovered") if one > at) - at

    def _ended_after(self, at: float) -> float:
        """Return how long after a moment of its own the operator's machine told that contact is lost."""
        look = f"journalctl -u {AGENT} -o short-monotonic --no-pager | grep 'waiting for the robot' | tail -1"
        line = until(lambda: self._at_operator(look), "the agent tells")
        return float(line.split("]")[0].strip("[ ")) - at

    def _events(self, *kinds: str) -> list[float]:
        """Return when the robot told of something, by its machine's time since its start."""
        words = "python3 -c 'import time; print(time.time() - time.monotonic())'"
        offset_s = float(self.robot.machine.run(words).stdout)
        return [one["wall_ns"] / 1e9 - offset_s for one in self._reported() if one["kind"] in kinds]

    def _reported(self) -> list[dict[str, Any]]:
        said = self.robot.machine.run(f"{AS_SERVICE} send --json /report/events", limit_s=WAIT_S).stdout
        return list(json.loads(said)["data"])

    def _at_operator(self, words: str) -> str:
        done = self.operator.machine.run(words, check=False, limit_s=WAIT_S)
        if done.returncode:
            raise SceneError(f"{words[-60:]}: {done.stderr.decode()[-300:]}")
        return done.stdout.decode().strip()

    def _phases(self) -> str:
        return ", ".join(f"{name} {one['phase']}" for name, one in self.robot.capabilities().items())

    def _phase(self, name: str) -> Any:
        return self.robot.capabilities()[name]["phase"]

    @staticmethod
    def _boot(one: Stage) -> str:
        return one.machine.run("cat /proc/sys/kernel/random/boot_id").stdout.decode().strip()


def _is_made(folder: Path, own: Path) -> bool:
    made = own / "made"
    return made.exists() and made.stat().st_mtime > (folder / "initrd.img").stat().st_mtime


def _make(folder: Path, own: Path, send: Send) -> None:
    """Make a machine of its own from the one that was built: it starts by itself, and is kept as it is then."""
    own.mkdir(exist_ok=True)
    for name in ("vmlinuz", "initrd.img", "key", processor.KEPT, processor.TREE):
        (own / name).unlink(missing_ok=True)
        if (folder / name).exists():
            (own / name).symlink_to(folder / name)
    shutil.copy(folder / "disk.qcow2", own / "disk.qcow2")
    made = Stage(Machine(own), send, UNIT)
    try:
        made.machine.start(snapshot=True)
        install, starts = MADE[own.name]
        _name(made, own.name)
        install(made)
        made.off("systemctl reboot")
        made.machine = Machine(own, cable=f"listen=127.0.0.1:{free_port()}")
        made.machine.start(snapshot=False)
        starts(made)
        made.machine.monitor(f"savevm {APART}")
    finally:
        made.machine.cut()
    (own / "made").touch()


def _name(made: Stage, name: str) -> None:
    made.machine.run(
        f"echo {name} >/etc/hostname; echo 127.0.0.1 localhost {name} >/etc/hosts; rm -f /etc/machine-id; systemd-machine-id-setup"
    )
    _write(made, "/etc/systemd/system/lab-cable.service", CABLE_UNIT.format(ADDRESSES[name]))
    _write(made, "/etc/systemd/system/lab-clock.service", abreast.UNIT)


def _robot(made: Stage) -> None:
    made.plays("wheels")
    made.machine.run(f"{PLAYED} prepare two")
    _write(made, "/etc/lbr/two.toml", PROFILE)
    made.machine.run("/opt/lbr/bin/lbr service install /etc/lbr/two.toml", limit_s=WAIT_S)
    made.machine.run(f"systemctl enable lab-cable lab-clock lab-player {UNIT}")


def _operator(made: Stage) -> None:
    made.plays("ring")
    made.machine.run("install -d -o lbr -g lbr -m 700 /var/lib/lbr")
    _write(made, f"/etc/systemd/system/{AGENT}", AGENT_UNIT)
    made.machine.run(f"systemctl enable lab-cable lab-clock lab-player {AGENT}")


def _robot_starts(made: Stage) -> None:
    """Have it ready, and keep outside what lets others in."""
    made.ready()
    for name, role in (("operator", "host"), ("phone", "operate")):
        file = f"--file /var/lib/lbr/{name}.json5" if role == "operate" else ""
        said = made.machine.run(f"{AS_SERVICE} token add {name} --role {role} {file}", limit_s=WAIT_S).stdout
        (made.machine.folder.parent / f"{name}.token").write_bytes(said)
    configuration = made.machine.run("cat /var/lib/lbr/phone.json5").stdout
    (made.machine.folder.parent / "phone.json5").write_bytes(configuration)


def _operator_starts(made: Stage) -> None:
    """Give it what lets it in; its agent waits for the robot."""
    folder = made.machine.folder.parent
    _write(made, "/root/phone.json5", (folder / "phone.json5").read_text())
    _write(made, "/var/lib/lbr/operator.token", (folder / "operator.token").read_text())
    made.machine.run("cd /var/lib/lbr && chown lbr:lbr operator.token && chmod 600 operator.token")
    made.machine.run("mkdir -p -m 700 /root/lbr && sync")  # it is to lose its power later
    look = f"journalctl -u {AGENT} --no-pager | grep 'waiting for the robot'"
    until(lambda: made.machine.run(look, check=False).stdout, "the agent waits")


MADE = {"robot": (_robot, _robot_starts), "operator": (_operator, _operator_starts)}


def _write(made: Stage, path: str, text: str) -> None:
    made.machine.run(f"mkdir -p $(dirname {path}) && cat >{path}", data=text.encode())
