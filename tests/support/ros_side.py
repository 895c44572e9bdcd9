"""A node of ROS 2 as rmw_zenoh has it on the wire, by zenoh alone: a drive of teleop, a subscriber, a client of services.

ros_side.py ENDPOINT                                 publishes a twist on /cmd_vel 20 times a second, until it is killed
ros_side.py ENDPOINT --once TOPIC TYPE HASH HEX      publishes a message once, and stays
"""

import json
import select
import signal
import struct
import sys
import time
import uuid

import xxhash
import zenoh

TWIST = "geometry_msgs::msg::dds_::Twist_", "RIHS01_9c45bf16fe0983d80e3cfe750d6835843d265a9a6c46bd2e609fcddde6fb8d2a"
STAMPED = (
    "geometry_msgs::msg::dds_::TwistStamped_",
    "RIHS01_5f0fcd4f81d5d06ad9b4c4c63e3ea51b82d6ae4d0558f1d475229b1121db6f64",
)
ODOMETRY = "nav_msgs::msg::dds_::Odometry_", "RIHS01_3cc97dc7fb7502f8714462c526d369e35b603cfc34d946e3f2eda2766dfec6e0"
TRIGGER = "std_srvs::srv::dds_::Trigger_", "RIHS01_eeff2cd6fa5ad9d27cdf4dec64818317839b62f212a91e6b5304b634b2062c5f"
STRING = "std_msgs::msg::dds_::String_", "RIHS01_df668c740482bbd48fb39d76a70dfd4bd59db1288021743503259e948f6b1a18"
TF = "tf2_msgs::msg::dds_::TFMessage_", "RIHS01_e369d0f05a23ae52508854b66f6aa0437f3449d652e8cbf22d5abe85d020f087"
HEAD = b"\x00\x01\x00\x00"


def twist(vx: float = 0.0, wz: float = 0.0) -> bytes:
    """Return a Twist."""
    return HEAD + struct.pack("<6d", vx, 0.0, 0.0, 0.0, 0.0, wz)


def stamped(vx: float, made_s: float) -> bytes:
    """Return a TwistStamped of a frame without a name."""
    sec = int(made_s)
    head = struct.pack("<iII", sec, round((made_s - sec) * 1e9), 1) + b"\x00" + b"\x00" * 3
    return HEAD + head + struct.pack("<6d", vx, 0.0, 0.0, 0.0, 0.0, 0.0)


def opened(endpoint: str, *, router: bool = False) -> zenoh.Session:
    """Open a session to a router, or be one, as `rmw_zenohd` is."""
    settings = {
        "mode": "router" if router else "client",
        "listen" if router else "connect": {"endpoints": [endpoint]},
        "scouting": {"multicast": {"enabled": False}, "gossip": {"enabled": False}},
        "transport": {"shared_memory": {"enabled": False}},
    }
    return zenoh.open(zenoh.Config.from_json5(json.dumps(settings)))


class Node:
    """A node; what it declares stays until it is closed."""

    def __init__(self, session: zenoh.Session, name: str = "teleop") -> None:
        self._session = session
        self._own = f"@ros2_lv/0/{session.zid()}/0"
        self._name = name
        self._ids = 0
        self.held = [session.liveliness().declare_token(f"{self._own}/0/NN/%/%/{name}")]

    def endpoint(self, kind: str, topic: str, type_: tuple[str, str]) -> bytes:
        """Show an endpoint, and return its gid."""
        self._ids += 1
        dds, hash_ = type_
        token = f"{self._own}/{self._ids}/{kind}/%/%/{self._name}/%{topic}/{dds}/{hash_}/::,10:,:,:,,"
        self.held.append(self._session.liveliness().declare_token(token))
        return xxhash.xxh3_128(token.encode()).intdigest().to_bytes(16, "little")

    def publisher(self, topic: str, type_: tuple[str, str]) -> "Publisher":
        """Publish on a topic."""
        return Publisher(self._session, key(topic, type_), self.endpoint("MP", topic, type_))

    def subscribe(self, topic: str, type_: tuple[str, str], heard: list[zenoh.Sample]) -> None:
        """Subscribe to a topic."""
        self.held.append(self._session.declare_subscriber(key(topic, type_), heard.append))
        self.endpoint("MS", topic, type_)

    def call(self, service: str) -> tuple[bool, str]:
        """Call a Trigger, and return its answer."""
        gid = self.endpoint("SC", service, TRIGGER)
        attachment = struct.pack("<qqB", 1, time.time_ns(), 16) + gid
        replies = self._session.get(key(service, TRIGGER), payload=HEAD + b"\x00", attachment=attachment, timeout=20.0)
        for reply in replies:
            assert reply.ok is not None
            assert reply.ok.attachment.to_bytes() == attachment
            data = reply.ok.payload.to_bytes()
            return bool(data[4]), data[12:-1].decode()
        raise AssertionError("no answer")


class Publisher:
    """A publisher of messages that are bytes already."""

    def __init__(self, session: zenoh.Session, key_: str, gid: bytes) -> None:
        self._publisher = session.declare_publisher(key_, encoding="application/cdr")
        self._gid = gid
        self._sequence = 0

    def put(self, payload: bytes, *, late_s: float = 0.0) -> None:
        """Publish a message, that was sent some time ago."""
        self._sequence += 1
        sent_ns = time.time_ns() - round(late_s * 1e9)
        self._publisher.put(payload, attachment=struct.pack("<qqB", self._sequence, sent_ns, 16) + self._gid)


def key(topic: str, type_: tuple[str, str]) -> str:
    """Return the key of a topic."""
    return "/".join(["0", topic, *type_])


def main(endpoint: str, *, lines: bool) -> None:
    """Drive, by what lines of input ask for or ahead."""
    with opened(endpoint) as session:
        node = Node(session, f"teleop_{uuid.uuid4().hex[:6]}")
        publisher = node.publisher("cmd_vel", TWIST)
        wanted = None if lines else [0.2, 0.0]
        print(json.dumps({"ready": True}), flush=True)
        while True:
            if select.select([sys.stdin] if lines else [], [], [], 0.05)[0]:
                wanted = json.loads(sys.stdin.readline() or "null")["twist"]
                print(json.dumps({"sent_ns": time.monotonic_ns()}), flush=True)
            if wanted is not None:
                publisher.put(twist(*wanted))


if __name__ == "__main__":
    if "--router" in sys.argv:
        with opened(sys.argv[1], router=True):
            signal.pause()
    if "--once" in sys.argv:
        topic, dds, hash_, payload = sys.argv[3:]
        with opened(sys.argv[1]) as session:
            node = Node(session)
            node.publisher(topic, (dds, hash_)).put(bytes.fromhex(payload))
            signal.pause()
    main(sys.argv[1], lines="--lines" in sys.argv)
