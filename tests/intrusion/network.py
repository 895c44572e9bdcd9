"""A1: what a robot as it ships shows and sends to the network: nothing. Its web servers are at the loopback alone."""

import json
import subprocess
import sys

from tests.support import programs
from tests.support.bench import Bench, let_go, temporary_home
from tests.support.figures import Results
from tests.support.netns import Network, network, why_not
from tests.support.robot import start

ALL_HOSTS = "010000E0"
LOOPBACK = "0100007F:"
"""127.0.0.1, as the kernel writes it; there is no IPv6 in this network."""
SETTLE_S = 1.0
PORTS = 65535
SPOKEN, ARP = b"our own", "0806"
SPEAK = f"import socket, sys; socket.socket(type=socket.SOCK_DGRAM).sendto({SPOKEN!r}, (sys.argv[1], 9))"
NO_IPV6 = "for one in /proc/sys/net/ipv6/conf/*/disable_ipv6; do echo 1 > $one; done"
"""The kernel itself says things in IPv6 when a cable is plugged in."""
CAPTURE = """
import socket, sys, select, json
s = socket.socket(socket.AF_PACKET, socket.SOCK_RAW, socket.htons(3))
print("listening", flush=True)
seen = []
while select.select([sys.stdin, s], [], [])[0][0] is not sys.stdin:
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
    return not why_not()


def silence(results: Results, seconds: float) -> None:
    """Run a robot on a machine of its own and drive it; listen for `seconds`, then knock at every port."""
    with network() as net, temporary_home(whole=True) as home:
        for place in (net.robot, net.client):
            programs.run([*place, "sh", "-c", NO_IPV6], check=False)
        programs.run([*net.robot, "ip", "route", "add", "default", "via", net.client_address], check=True)
        Bench.pass_time(SETTLE_S)
        capture = _python(net, CAPTURE)
        assert capture.stdout is not None
        assert capture.stdout.readline().strip() == "listening"
        robot = start(home, prefix=net.robot)
        try:
            under_test = Bench(robot, results)
            mover = under_test.drive()
            under_test.pass_time(seconds)
            mover.cease()
            programs.run([*net.robot, sys.executable, "-c", SPEAK, net.client_address], check=True)
            under_test.pass_time(SETTLE_S)
            results.check("A1", _packets(json.loads(capture.communicate("\n")[0])))
            open_ports = json.loads(_python(net, SCAN, net.address, str(PORTS + 1)).communicate()[0])
            results.check("A1", [f"TCP ports are open: {open_ports}"] if open_ports else [])
            results.of("A1").checks += PORTS - 1
            results.check("A1", _sockets(net))
        finally:
            let_go(robot)


def _packets(frames: list[str]) -> list[str]:
    """Return what the robot has sent; the one packet that we sent in its place must have been heard."""
    ours = [frame for frame in frames if SPOKEN.hex() in frame]
    others = [frame for frame in frames if frame not in ours and frame[24:28] != ARP]
    found = [f"{len(others)} packets left the robot, such as {others[0]}"] if others else []
    return found if ours else [*found, "our own packet was not heard, so nothing was listened to"]


def _sockets(net: Network) -> list[str]:
    """Return every TCP and UDP socket beyond the loopback, and every multicast group beyond the one that all hosts are in."""
    found = []
    for table in ("tcp", "tcp6", "udp", "udp6", "raw", "raw6", "udplite"):
        places = [line.split()[1] for line in _read(net, table)[1:]]
        found += [f"{table}: {place}" for place in places if not place.startswith(LOOPBACK)]
    groups = [line.split()[0] for line in _read(net, "igmp") if line[:1] == "\t"]
    return found + [f"multicast group {group}" for group in groups if group != ALL_HOSTS]


def _read(net: Network, table: str) -> list[str]:
    done = programs.run([*net.robot, "cat", f"/proc/net/{table}"], capture_output=True, text=True, check=False)
    return done.stdout.splitlines()


def _python(net: Network, program: str, *arguments: str) -> "subprocess.Popen[str]":
    command = [*net.client, sys.executable, "-c", program, *arguments]
    return programs.start(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
