"""A node by pyzeros: `pyzeros_node.py ENDPOINT`. Lines of input are JSON, and so are those of output.

{"twist": [vx, wz]}     goes on publishing it on /cmd_vel, 20 times a second; null ends that
{"call": "stop"}        calls a Trigger
"""

import asyncio
import json
import os
import sys
import time
from pathlib import Path

os.environ.setdefault("CYDR_CACHE_DIR", str(Path(sys.prefix) / "cydr_cache"))  # else in each folder anew, for minutes

import pyzeros
import zenoh
from ros2_pyterfaces.cydr.all_msgs import Odometry, Twist, Vector3
from ros2_pyterfaces.cydr.all_srvs import Trigger


def twist(vx: float, wz: float) -> Twist:
    return Twist(linear=Vector3(x=vx, y=0.0, z=0.0), angular=Vector3(x=0.0, y=0.0, z=wz))


def tell(**said: object) -> None:
    print(json.dumps(said), flush=True)


class Teleop:
    """Publishes what is wanted, and tells what odometry comes."""

    def __init__(self, node: pyzeros.Node) -> None:
        self.node = node
        self.publisher = node.create_publisher(Twist, "cmd_vel")
        self.odometry = node.create_subscriber(Odometry, "odom")
        self.wanted: list[float] | None = None

    async def listen(self) -> None:
        async for message in self.odometry.listen():
            at_s = message.header.stamp.sec + message.header.stamp.nanosec / 1e9
            tell(odom=[message.pose.pose.position.x, message.twist.twist.linear.x], age_s=time.time() - at_s)

    async def publish(self) -> None:
        while True:
            if self.wanted is not None:
                self.publisher.publish(twist(*self.wanted))
            await asyncio.sleep(0.05)

    async def obey(self, asked: dict) -> None:
        if "twist" in asked:
            self.wanted = asked["twist"]
            at_ns = time.monotonic_ns()
            if self.wanted is not None:
                self.publisher.publish(twist(*self.wanted))
            tell(sent_ns=at_ns)
        if "call" in asked:
            client = self.node.create_client(Trigger, asked["call"])
            answer = await asyncio.wait_for(client.call_async(Trigger.Request()), 20.0)
            tell(success=bool(answer.success), message=str(answer.message))


async def main(endpoint: str) -> None:
    settings = {"mode": "client", "connect": {"endpoints": [endpoint]}, "scouting": {"multicast": {"enabled": False}}}
    session = zenoh.open(zenoh.Config.from_json5(json.dumps(settings)))
    Twist.deserialize(twist(0.0, 0.0).serialize())  # compiled at its first use, for minutes
    Odometry.deserialize(Odometry().serialize())
    Trigger.Request().serialize()
    Trigger.Response.deserialize(Trigger.Response(success=True, message=b"").serialize())
    with pyzeros.auto_context(node="by_pyzeros", zenoh_session=session) as node:
        teleop = Teleop(node)
        tasks = [asyncio.create_task(teleop.listen()), asyncio.create_task(teleop.publish())]
        tell(ready=True)
        while line := await asyncio.to_thread(sys.stdin.readline):
            await teleop.obey(json.loads(line))
        for task in tasks:
            task.cancel()


if __name__ == "__main__":
    asyncio.run(main(sys.argv[1]))
