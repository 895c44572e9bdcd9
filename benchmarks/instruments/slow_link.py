"""A bad link, as a program of its own: `slow_link.py PORT DELAY_S LOSS GAP_S`.

It passes connections on to a port of this machine, and prints its own port. Each byte arrives `delay_s` later. A share
`loss` of all pieces is lost once, with the effect of TCP: the piece and all behind it arrive after a repetition. Every
5 s nothing passes for `gap_s`.
"""

import asyncio
import random
import sys
from functools import partial

RESENT_S = 0.2
"""Linux repeats a lost segment after at least this time (TCP_RTO_MIN)."""
GAP_EVERY_S = 5.0
PIECE = 65_536


async def _pass(
    source: asyncio.StreamReader, sink: asyncio.StreamWriter, delay_s: float, loss: float, gap_s: float
) -> None:
    """Pass one direction on, in order."""
    clock = asyncio.get_running_loop().time
    waiting: asyncio.Queue[tuple[float, bytes]] = asyncio.Queue()

    async def read() -> None:
        while data := await source.read(PIECE):
            due = clock() + delay_s + (RESENT_S if random.random() < loss else 0.0)
            waiting.put_nowait((due + max(0.0, gap_s - due % GAP_EVERY_S), data))
        waiting.put_nowait((0.0, b""))

    reading = asyncio.create_task(read())
    try:
        while True:
            due, data = await waiting.get()
            await asyncio.sleep(max(0.0, due - clock()))
            if not data:
                break
            sink.write(data)
            await sink.drain()
    except OSError:
        pass  # the other end is closed
    finally:
        reading.cancel()
        sink.close()


async def _main(port: int, delay_s: float, loss: float, gap_s: float) -> None:
    async def connect(reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        far_reader, far_writer = await asyncio.open_connection("127.0.0.1", port)
        there = partial(_pass, delay_s=delay_s, loss=loss, gap_s=gap_s)
        await asyncio.gather(there(reader, far_writer), there(far_reader, writer))

    server = await asyncio.start_server(connect, "127.0.0.1", 0)
    print(server.sockets[0].getsockname()[1], flush=True)
    await server.serve_forever()


if __name__ == "__main__":
    asyncio.run(_main(int(sys.argv[1]), *map(float, sys.argv[2:])))
