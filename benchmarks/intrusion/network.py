"""A1: what a robot with the default profile shows and sends to the network: nothing."""

import json
import os
import select
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from benchmarks.bench import Bench, let_go, temporary_home
from benchmarks.figures import Results
from tests.robot import LBR, Robot, environment

OURS, THEIRS = "10.213.7.1", "10.213.7.2"
ALL_HOSTS = "010000E0"
READY_S = 20.0
CAPTURE = """
import socket, sys, select, json
s = socket.socket(socket.AF_PACKET, socket.SOCK_RAW, socket.htons(3))
s.bind((sys.argv[1], 0))
print("listening", flush=True)
seen = []
while not select.select([sys.stdin, s], [], [])[0][0] is sys.stdin:
    frame, where = s.recvfrom(2048)
    if where[2] != 4:
        seen.append(frame[:60].hex())
print(json.dumps(seen))
"""
SCAN = """
import socket, sys, json
found = []
for port in range(1, int(sys.argv[2])):
    s = socket.socket()
    s.settimeout(1.0)
    if s.connect_ex((sys.argv[1], port)) == 0:
        found.append(port)
    s.close()
print(json.dumps(found))
"""


def possible() -> bool:
    """Say whether this machine lets us make network namespaces."""
    try:
        return os.geteuid() == 0 and _ip("netns", "list").returncode == 0
    except FileNotFoundError:
        return False


def silence(results: Results, seconds: float, ports: int = 65535) -> None:
    """Run a robot in a network of its own and drive it; capture for `seconds`, then knock at every port."""
    with _two_namespaces() as (inside, outside), temporary_home() as home:
        capture = _python(outside, CAPTURE, "knock")
        assert capture.stdout is not None
        assert capture.stdin is not None
        assert capture.stdout.readline().strip() == "listening"
        robot = _start(home, inside)
        try:
            under_test = Bench(robot, results)
            mover = under_test.drive()
            under_test.pass_time(seconds)
            mover.cease()
            seen = json.loads(capture.communicate("\n")[0])
            results.check("A1", [f"{len(seen)} packets left the robot, such as {seen[0]}"] if seen else [])
            open_ports = json.loads(_python(outside, SCAN, OURS, str(ports + 1)).communicate()[0])
            results.check("A1", [f"TCP ports are open: {open_ports}"] if open_ports else [])
            results.check("A1", _sockets(inside))
        finally:
            let_go(robot)


def _sockets(namespace: str) -> list[str]:
    """Return every TCP and UDP socket, and every multicast group beyond the one that all hosts are in."""
    found = []
    for table in ("tcp", "tcp6", "udp", "udp6", "raw", "raw6", "udplite"):
        lines = _in(namespace, "cat", f"/proc/net/{table}").stdout.splitlines()[1:]
        found += [f"{table}: {line.split()[1]}" for line in lines]
    groups = [
        line.split()[0] for line in _in(namespace, "cat", "/proc/net/igmp").stdout.splitlines() if line[:1] == "\t"
    ]
    return found + [f"multicast group {group}" for group in groups if group != ALL_HOSTS]


def _start(home: Path, namespace: str) -> Robot:
    with (home / "stderr.txt").open("ab") as errors:
        popen = subprocess.Popen(
            ["ip", "netns", "exec", namespace, *LBR, "run", "--no-console"],
            env=environment(home),
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=errors,
            text=True,
        )
    assert popen.stdout is not None
    readable, _, _ = select.select([popen.stdout], [], [], READY_S)
    line = popen.stdout.readline() if readable else ""
    if not line:
        popen.kill()
        raise AssertionError(f"no ready line: {(home / 'stderr.txt').read_text()[-2000:]}")
    return Robot(home, popen, json.loads(line))


@contextmanager
def _two_namespaces() -> Iterator[tuple[str, str]]:
    """Give two namespaces with one cable between them, on which the kernel itself says nothing."""
    inside, outside = f"lbr-in-{os.getpid()}", f"lbr-out-{os.getpid()}"
    setup: list[tuple[str, ...]] = [
        ("netns", "add", inside),
        ("netns", "add", outside),
        ("-n", inside, "link", "add", "wire", "type", "veth", "peer", "name", "knock", "netns", outside),
        ("-n", inside, "addr", "add", f"{OURS}/24", "dev", "wire"),
        ("-n", outside, "addr", "add", f"{THEIRS}/24", "dev", "knock"),
    ]
    try:
        for words in setup:
            _must(_ip(*words))
        for name, link in ((inside, "wire"), (outside, "knock")):
            _in(name, "sh", "-c", "echo 1 | tee /proc/sys/net/ipv6/conf/*/disable_ipv6")
            for one in ("lo", link):
                _must(_ip("-n", name, "link", "set", one, "up"))
        _must(_ip("-n", inside, "route", "add", "default", "via", THEIRS))
        yield inside, outside
    finally:
        _ip("netns", "del", inside)
        _ip("netns", "del", outside)


def _python(namespace: str, program: str, *arguments: str) -> "subprocess.Popen[str]":
    return subprocess.Popen(
        ["ip", "netns", "exec", namespace, sys.executable, "-c", program, *arguments],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
    )


def _ip(*words: str) -> "subprocess.CompletedProcess[str]":
    return subprocess.run(["ip", *words], capture_output=True, text=True, check=False)


def _in(namespace: str, *words: str) -> "subprocess.CompletedProcess[str]":
    return _ip("netns", "exec", namespace, *words)


def _must(done: "subprocess.CompletedProcess[str]") -> None:
    assert done.returncode == 0, done.stderr
