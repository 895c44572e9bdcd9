"""The reaper's program: ends what is left of a run when the executive is gone, also what is frozen or hangs.

`python -I -S reap.py LBR_RUN=TOKEN. LBR_LAST_WORD_S= PID HANGS_S`, with a pipe from the executive, which is PID, on
standard input. It hears there `+NUMBER PID` when a process was started, `*NUMBER PID` when a driver was, `-NUMBER` when
one has ended, `~NUMBER` when one has ended that may leave something behind until the end of the run, and `=PID` of a
driver that had ended before. `!` says that the executive's main loop goes round, and `_` that this is not to be waited
for that. A dot, or the end of the pipe, is the end of the executive: who can, ends in order by itself; then all the
rest is killed. An executive that hangs is killed first. To a process belongs what is in its session, and what has its
mark in the environment. A guard is not killed but continued until it has said its last word; only in a driver's session
is one, which no other process can enter. The reaper has the executive's rights, so that it sees and ends whatever that
has started, and imports nothing of the project.
"""

import os
import select
import signal
import sys
import time
from collections.abc import Callable, Collection, Iterator, Mapping
from contextlib import suppress
from typing import NamedTuple

PATIENCE_S = 1.1
"""A capability that ends in order is gone 1.0 s after its lifeline closed: its own alarm sees to that."""
LAST_WORD_MOST_S = 7200.0
MOST_GUARDED = 512
"""Sessions of drivers, running or ended; a machine runs at most 100 processes of a robot."""
LOOK_FIRST_S, LOOK_MOST_S = 0.01, 0.25
LEFT_S = 0.5
"""The pace at which remains of ended processes are looked at again."""
AWAKE_S, AWAKE_AT_THE_END_S = 1.0, 0.1
"""Frozen for this long at most: a tenth of the patience with an executive that hangs, and with what is left of one."""
DEAD = "ZX"
END, BEAT, REST = b".", b"!", b"_"
SUSPICIOUS_S = 2.0
"""From here on it is looked at who has the processor."""
OTHERS_EXCUSE = 2.0
"""The thread that holds the interpreter's lock may wait for the processor in the main thread's stead. Threads that
merely carry messages wait as well, so this excuses no longer than this many times its patience."""
ELSEWHERE = "Dt"
"""The main thread waits for a disk, or a debugger has it: it cannot be ended, or is stopped on purpose."""


class Process(NamedTuple):
    """A process on this machine; `started` tells it from a later one of the same number, `number` is -1 without a
    mark."""

    pid: int
    started: str
    session: int
    number: int
    last_word_s: float


class Thread(NamedTuple):
    """The times of a thread so far: how long it `ran` and `waited` for a processor, and its state."""

    ran: float
    waited: float
    state: str


class Silence:
    """The executive hangs: it was silent for `patience_s`, not counting the time that the machine kept from it. Pure.

    One that a person has frozen (SIGSTOP, Ctrl-Z) counts as one that hangs: the robot cannot be stopped by it.
    """

    def __init__(self, patience_s: float) -> None:
        self._patience_s = patience_s
        self._waiting = False
        self._since = self._at = 0.0
        self._counted = self._by_main = 0.0
        self._before: Mapping[int, Thread] | None = None

    @property
    def watched(self) -> bool:
        """Return whether beats are expected."""
        return self._waiting

    def beat(self, now: float) -> None:
        """Hear that the main loop goes round."""
        self._waiting, self._since, self._at, self._before = True, now, now, None
        self._counted = self._by_main = 0.0

    def rest(self) -> None:
        """Expect no more beats until the next one."""
        self._waiting = False

    def hangs(self, now: float, look: Callable[[], Mapping[int, Thread]], main: int) -> bool:
        """Return whether it hangs; called about twice a second, or what goes by unseen is not counted."""
        if not self._waiting or now - self._since < SUSPICIOUS_S:
            return False
        threads = look()
        elapsed = now - self._at
        if self._before is None:
            self._counted = self._by_main = min(elapsed, SUSPICIOUS_S + LEFT_S)
        elif main not in threads or threads[main].state not in ELSEWHERE:
            both = self._before.keys() & threads.keys()
            waits = {one: _waited(self._before[one], threads[one], elapsed) for one in both}
            seen = min(elapsed, 2.0 * LEFT_S)
            self._counted += max(0.0, seen - max(waits.values(), default=0.0))
            self._by_main += max(0.0, seen - waits.get(main, 0.0))
        self._at, self._before = now, threads
        return self._counted > self._patience_s or self._by_main > OTHERS_EXCUSE * self._patience_s


def _waited(before: Thread, now: Thread, elapsed: float) -> float:
    """Return how long a thread has waited for the processor; the kernel counts a wait only when it is over."""
    waited = now.waited - before.waited
    if now.state == "R":
        waited = max(waited, elapsed - (now.ran - before.ran))
    return min(elapsed, max(0.0, waited))


def threads_of(pid: int) -> dict[int, Thread]:
    """Look at the threads of a process; what cannot be read has had nothing."""
    threads = {}
    with suppress(OSError):
        for name in os.listdir(f"/proc/{pid}/task"):  # noqa: PTH208 - importing pathlib takes too long
            with suppress(OSError, ValueError, IndexError):
                state = _read(f"/proc/{pid}/task/{name}/stat").rpartition(b")")[2].split()[0].decode()
                ran, waited = (0, 0)
                with suppress(OSError):  # a kernel that counts nothing
                    ran, waited = map(int, _read(f"/proc/{pid}/task/{name}/schedstat").split()[:2])
                threads[int(name)] = Thread(ran / 1e9, waited / 1e9, state)
    return threads


class Run:
    """The processes that the executive has started; only those of this user are searched to the bottom."""

    def __init__(self, mark: bytes, last_word: bytes, clock: Callable[[], float] = time.monotonic) -> None:
        self._mark = mark
        self._last_word = last_word
        self._clock = clock
        self._running: dict[int, int] = {}
        self._left: dict[int, int] = {}
        self._guarded: dict[int, None] = {}
        self._guards: dict[tuple[int, str], float] = {}
        self._beyond: set[tuple[int, str]] = set()

    @property
    def tidy(self) -> bool:
        """Return whether nothing is known to be left behind by what has ended."""
        return not self._left

    def hear(self, word: bytes) -> None:
        """Take down what the executive has started, or what has ended."""
        if word == END:
            return
        sign, number = word[:1], int(word[1:].split()[0])
        if sign == b"=":
            self._guarded[number] = None
            return
        if sign in {b"+", b"*"}:
            session = self._running[number] = int(word.split()[1])
            self._guarded.pop(session, None)
            if sign == b"*":
                self._guarded[session] = None
            while len(self._guarded) > MOST_GUARDED:
                del self._guarded[next(iter(self._guarded))]
            return
        session = self._running.pop(number, 0)
        if sign == b"-" and session:
            self._left[number] = session

    def clear(self) -> None:
        """End what processes that have ended have left behind; what is not gone at once is looked at again."""
        sessions = {session: number for number, session in self._left.items()}
        found = self._end(sessions, self._left) if sessions else []
        still = {sessions.get(one.session, one.number) for one in found}
        self._left = {number: session for number, session in self._left.items() if number in still}

    def end(self, done: Callable[[], object]) -> None:
        """Let end what ends by itself, then end the rest; return when nothing is left that can be ended.

        Calls `done` again and again while none but guards are left.
        """
        self._wait(self._clock() + PATIENCE_S)
        sessions = {*self._left.values(), *self._running.values()}
        pause_s = LOOK_FIRST_S
        while found := self._end(sessions, None):
            if all(one.last_word_s for one in found):
                done()
            time.sleep(pause_s)
            pause_s = min(2.0 * pause_s, LOOK_MOST_S)

    def _wait(self, until: float) -> None:
        """Wait until all that the executive has started by itself is gone."""
        poll = select.poll()
        running = set()
        for pid in self._running.values():
            with suppress(OSError):
                running.add(os.pidfd_open(pid))
        for fd in running:
            poll.register(fd, select.POLLIN)
        while running and (left_s := until - self._clock()) > 0.0:
            for fd, _ in poll.poll(left_s * 1000.0):
                poll.unregister(fd)
                running.discard(fd)

    def _end(self, sessions: Collection[int], numbers: Collection[int] | None) -> list[Process]:
        """Kill what belongs to these sessions or bears one of these marks (None: any); return what may still be there.

        A fork that leaves faster than it is looked at is met as a group alone. A guard leads a group of
        its own.
        """
        for session in sessions:
            with suppress(OSError):
                os.killpg(session, signal.SIGKILL)
        processes = [
            process
            for process in self._processes()
            if process.session in sessions or (process.number >= 0 and (numbers is None or process.number in numbers))
        ]
        return [
            process
            for process in processes
            if (process.pid, process.started) not in self._beyond and self._treat(process)
        ]

    def _treat(self, process: Process) -> bool:
        """Kill it, or continue it if it is a guard whose time is not over; say whether it is still ours to end."""
        known = (process.pid, process.started)
        number = signal.SIGKILL
        if process.last_word_s > 0.0:
            until = self._guards.setdefault(known, self._clock() + min(process.last_word_s, LAST_WORD_MOST_S))
            number = signal.SIGCONT if self._clock() < until else signal.SIGKILL
        try:
            fd = os.pidfd_open(process.pid)
        except OSError:
            return False
        try:
            if self._look(process.pid) == process:
                signal.pidfd_send_signal(fd, number)
        except ProcessLookupError:
            return False
        except PermissionError:
            self._beyond.add(known)
            return False
        finally:
            os.close(fd)
        return True

    def _processes(self) -> Iterator[Process]:
        me = os.getpid()
        for name in os.listdir("/proc"):  # noqa: PTH208 - importing pathlib takes too long
            if name.isdecimal() and int(name) != me and (found := self._look(int(name))) is not None:
                yield found

    def _look(self, pid: int) -> Process | None:
        """Return a process as it is now, unless it is dead; what it does not show us it does not have."""
        try:
            fields = _read(f"/proc/{pid}/stat").rpartition(b")")[2].split()
        except OSError:
            return None
        if fields[0].decode() in DEAD:
            return None
        environment = b""
        with suppress(OSError):
            environment = b"\0" + _read(f"/proc/{pid}/environ")
        number = _after(environment, self._mark)
        session = int(fields[3])
        seconds = _after(environment, self._last_word) if session in self._guarded else b""
        return Process(
            pid,
            started=fields[19].decode(),
            session=session,
            number=int(number) if number.isdigit() else -1,
            last_word_s=float(seconds) if seconds.isdigit() else 0.0,
        )


def _read(path: str) -> bytes:
    with open(path, "rb", buffering=0) as file:  # noqa: PTH123 - importing pathlib takes too long
        return file.read()


def _after(environment: bytes, variable: bytes) -> bytes:
    """Return what follows the beginning of a variable, up to its end."""
    return environment.partition(b"\0" + variable)[2].partition(b"\0")[0]


def stay_awake(every_s: float) -> None:
    """Have the kernel continue this process every so often, should it be frozen: who writes to it may be frozen too."""
    import ctypes  # noqa: PLC0415 - takes 30 ms, in which the executive does not wait for this program

    class Event(ctypes.Structure):
        """`struct sigevent` of the C library: a signal at each expiry, as `way` 0 says."""

        _fields_ = (
            ("value", ctypes.c_void_p),
            ("number", ctypes.c_int),
            ("way", ctypes.c_int),
            ("rest", ctypes.c_char * 48),
        )

    timer = ctypes.c_void_p()
    every = (int(every_s), round(every_s % 1.0 * 1e9))
    with suppress(OSError, AttributeError):  # an old C library has timers elsewhere
        libc = ctypes.CDLL(None)
        event = Event(number=signal.SIGCONT)
        if libc.timer_create(time.CLOCK_MONOTONIC, ctypes.byref(event), ctypes.byref(timer)) == 0:
            libc.timer_settime(timer, 0, (ctypes.c_long * 4)(*every, *every), None)
    # a signal that is not taken is sent only once by newer kernels
    signal.signal(signal.SIGCONT, lambda _number, _frame: None)


class Executive:
    """The process that is watched: its beats go to `silence`."""

    def __init__(self, pid: int, hangs_s: float) -> None:
        self._pid = pid
        self._hangs_s = hangs_s
        self.silence = Silence(hangs_s)
        try:
            self._fd = os.pidfd_open(pid)
        except OSError:
            self._fd = -1
        if os.getppid() != pid and self._fd >= 0:  # it is gone, and the number may be another's
            os.close(self._fd)
            self._fd = -1

    def end_if_hung(self) -> bool:
        """Kill it if it hangs, and say why on its standard error, which then has no other writer."""
        if self._fd < 0 or not self.silence.hangs(time.monotonic(), lambda: threads_of(self._pid), self._pid):
            return False
        with suppress(OSError):
            signal.pidfd_send_signal(self._fd, signal.SIGKILL)
        say(
            f"reaper: the main loop of process {self._pid}, which runs the robot, stood still for {self._hangs_s:g} s: killed\n"
        )
        return True


def say(text: str) -> None:
    """Write a line to standard error, as far as that takes it at once."""
    with suppress(OSError):
        blocking = os.get_blocking(2)
        os.set_blocking(2, False)  # a shell may share it: only for this moment
        try:
            os.write(2, text.encode())
        finally:
            os.set_blocking(2, blocking)


def main(mark: bytes, last_word: bytes, pid: bytes, hangs_s: bytes) -> None:
    """Hear what the executive says for as long as it lives and beats, then end what is left."""
    for number in (signal.SIGTERM, signal.SIGINT, signal.SIGHUP, signal.SIGPIPE, signal.SIGTTOU):
        signal.signal(number, signal.SIG_IGN)
    stay_awake(AWAKE_S)
    run = Run(mark, last_word)
    executive = Executive(int(pid), float(hangs_s))
    poll = select.poll()
    poll.register(0, select.POLLIN)
    buffered = b""
    ended = False
    while not ended:
        quiet = run.tidy and not executive.silence.watched
        if poll.poll(None if quiet else LEFT_S * 1000.0):
            part = os.read(0, 65536)
            *words, buffered = (buffered + part).split(b"\n")
            ended = not part or END in words
            for word in words:
                if word == BEAT:
                    executive.silence.beat(time.monotonic())
                elif word == REST:
                    executive.silence.rest()
                else:
                    run.hear(word)
        ended = ended or executive.end_if_hung()
        run.clear()
    os.dup2(1, 2)
    stay_awake(AWAKE_AT_THE_END_S)
    run.end(lambda: os.dup2(1, 0))  # closes the pipe: the other end sees that


if __name__ == "__main__":
    main(*(os.fsencode(word) for word in sys.argv[1:]))
