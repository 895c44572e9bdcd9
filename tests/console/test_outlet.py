"""Output that is not read: nothing waits for it, and what is left out is counted."""

import fcntl
import os
import select
import threading

import pytest

from lbr.console.outlet import Outlet, Stream
from tests.support.waiting import until


@pytest.fixture
def pipe():
    """A pipe of one page."""
    reader, writer = os.pipe()
    fcntl.fcntl(writer, fcntl.F_SETPIPE_SZ, 4096)
    ends = [reader, writer]
    yield ends
    for fd in ends:
        if fd >= 0:
            os.close(fd)


@pytest.fixture
def outlet():
    made = Outlet(limit=8192)
    yield made
    made.close()


def read(fd: int) -> bytes:
    """Return what is there, within a moment."""
    return os.read(fd, 65536) if select.select([fd], [], [], 0.05)[0] else b""


def test_what_is_read_arrives_in_order(pipe, outlet):
    stream = Stream(outlet, pipe[1])
    print("a", "b", file=stream)
    print("c", end="", file=stream, flush=True)
    assert outlet.drain(5)
    assert read(pipe[0]) == b"a b\nc"


def test_nothing_waits_for_a_reader_and_what_is_left_out_is_counted(pipe, outlet):
    stream = Stream(outlet, pipe[1])
    for number in range(500):
        print(f"{number:099}", file=stream)
    until(lambda: outlet.stuck_s > 0.1)
    for number in range(500, 1000):
        print(f"{number:099}", file=stream)
    assert 0 < outlet.waiting <= 8192
    assert not outlet.drain(0.05)
    seen = b""
    while outlet.waiting:
        seen += read(pipe[0])
    print("back", file=stream)
    assert outlet.drain(5)
    seen += read(pipe[0])
    *lines, told, last = seen.decode().splitlines()
    whole = [int(line) for line in lines if line.isdecimal()]
    missed = [int(line[1:].split()[0]) for line in [*lines, told] if not line.isdecimal()]
    assert whole == sorted(whole)
    assert len(whole) + sum(missed) == 1000
    assert told.endswith("left out)")
    assert last == "back"


def test_closing_waits_for_nobody(pipe, outlet):
    Stream(outlet, pipe[1]).write("x" * 8000 + "\n")
    until(lambda: outlet.stuck_s > 0.05)
    outlet.close()
    assert Stream(outlet, pipe[1]).write("more\n") == 5


def test_a_reader_that_is_gone_is_an_error_once_it_is_known(pipe, outlet):
    os.close(pipe[0])
    pipe[0] = -1
    stream, lenient = Stream(outlet, pipe[1], strict=True), Stream(outlet, pipe[1])
    stream.write("a\n")
    until(lambda: outlet.error(pipe[1]))
    with pytest.raises(BrokenPipeError):
        stream.write("b\n")
    assert lenient.write("c\n") == 2
    assert outlet.drain(5)


def test_a_descriptor_that_others_made_non_blocking_gets_all(pipe, outlet):
    os.set_blocking(pipe[1], False)
    Stream(outlet, pipe[1]).write("y" * 8000 + "\n")
    until(lambda: outlet.stuck_s > 0.05)
    seen = b""
    while len(seen) < 8001:
        seen += read(pipe[0])
    assert outlet.drain(5)


def test_many_threads_print_whole_lines(pipe):
    outlet = Outlet()
    stream = Stream(outlet, pipe[1])
    writers = [
        threading.Thread(target=lambda n=n: [stream.write(f"{n}" * 20 + "\n") for _ in range(50)]) for n in range(8)
    ]
    for writer in writers:
        writer.start()
    seen = b""
    while seen.count(b"\n") < 400:
        seen += read(pipe[0])
    assert all(len(line) == 20 and len(set(line)) == 1 for line in seen.decode().splitlines())
    for writer in writers:
        writer.join(5)
    outlet.close()
