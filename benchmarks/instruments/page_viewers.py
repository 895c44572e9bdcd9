"""Pages that look at a robot, as a program of its own: `page_viewers.py URL COUNT RATE_HZ TOKEN...`.

Prints "open" once all of them have received something, and the frames a second of each when its input ends.
"""

import asyncio
import json
import sys
import time
from collections.abc import Sequence

from websockets.asyncio.client import connect
from websockets.typing import Subprotocol

HEARS = [
    "@status",
    "@event",
    "drive/state",
    "ranges/readings",
    "odometry/state",
    "attitude/state",
    "battery/state",
    "speech/state",
]


async def _look(url: str, number: int, rate_hz: float, token: str, count: list[int]) -> None:
    address = f"{url.replace('http', 'ws', 1)}/api/live"
    async with connect(address, subprotocols=[Subprotocol("lbr.live"), Subprotocol(f"bearer.{token}")]) as live:
        await live.send(json.dumps({"hear": HEARS, "rate_hz": rate_hz}))
        async for _ in live:
            count[number] += 1


async def _main(url: str, number: int, rate_hz: float, tokens: Sequence[str]) -> None:
    count = [0] * number
    looks = [_look(url, one, rate_hz, tokens[one % len(tokens)], count) for one in range(number)]
    tasks = [asyncio.create_task(look) for look in looks]
    while not all(count):
        for task in tasks:
            if task.done():
                await task
        await asyncio.sleep(0.05)
    print("open", flush=True)
    before, began = sum(count), time.monotonic()
    await asyncio.to_thread(sys.stdin.read)
    print((sum(count) - before) / number / (time.monotonic() - began), flush=True)
    for task in tasks:
        task.cancel()
    await asyncio.gather(*tasks, return_exceptions=True)


if __name__ == "__main__":
    asyncio.run(_main(sys.argv[1], int(sys.argv[2]), float(sys.argv[3]), sys.argv[4:]))
