"""The reaper's program: ends the remains of a run when the executive is gone, even if they are frozen or hang.

`python -I -S reap.py LBR_RUN=TOKEN. LBR_LAST_WORD_S= PID HANGS_S`: PID is the executive, whose pipe is the standard
input. Its words, a line each:

- `+NUMBER PID`: a process has started; `*NUMBER PID`: a driver has started.
- `-NUMBER`: it has ended; `~NUMBER`: it has ended, and its remains may run until the end of the run.
- `=PID`: this driver ended before the reaper began.
- `!`: the main loop runs; `_`: expect no beats until the next one.

A dot, or the end of the pipe, is the end of the executive. Processes that can end in order then do so by themselves;
the rest is killed. An executive that hangs is killed first.

The descendants of a process are those in its session, and those with its mark in the environment. A guard is not killed
but continued until it has sent its last command. Guards exist only in the sessions of drivers, which no other process
can enter.

The reaper has the executive's rights, so that it sees and ends all its processes. It imports nothing of the project.
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
"""A capability that ends in order is gone 1.0 s after its lifeline closed: its own alarm ensures that."""
LAST_WORD_MOST_S = 7200.0
MOST_GUARDED = 512
"""Sessions of drivers, running or ended; a machine runs at most 100 processes of a robot."""
LOOK_FIRST_S, LOOK_MOST_S = 0.01, 0.25
LEFT_S = 0.5
"""The interval between two looks at the remains of ended processes."""
AWAKE_S, AWAKE_AT_THE_END_S = 1.0, 0.1
"""The longest freeze: a tenth of its patience with an executive that hangs, and with the remains of one."""
DEAD = "ZX"
END, BEAT, REST = b".", b"!", b"_"
SUSPICIOUS_S = 2.0
"""After this silence, it checks which threads have the processor."""
OTHERS_EXCUSE = 2.0
"""The main thread may wait for a lock whose holder waits for the processor. Threads that merely carry messages wait as
well, so their waits excuse a silence only up to this multiple of the patience."""
ELSEWHERE = "Dt"
"""The main thread waits for a disk, or is stopped by a debugger: it cannot be killed, or was stopped on purpose."""


class Process(NamedTuple):
    """A process on this machine; `started` and the number identify it, `number` is -1 without a mark."""

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
    """Detects that the executive hangs: it was silent for `patience_s`, minus the time in which it waited for the
    processor. Pure.

    A frozen executive (SIGSTOP, Ctrl-Z) counts as hanging: it cannot stop the robot.
    """

    def __init__(self, patience_s: float) -> None:
        self._patience_s = patience_s
        self.watched = False
        self._since = self._at = 0.0
        self._counted = self._by_main = 0.0
        self._before: Mapping[int, Thread] | None = None

    def beat(self, now: float) -> None:
        """Note that the main loop runs."""
        self.watched, self._since, self._at, self._before = True, now, now, None
        self._counted = self._by_main = 0.0

    def rest(self) -> None:
        """Expect no more beats until the next one."""
        self.watched = False

    def hangs(self, now: float, look: Callable[[], Mapping[int, Thread]], main: int) -> bool:
        """Return whether it hangs; to be called about twice a second, as longer gaps are not counted."""
        if not self.watched or now - self._since < SUSPICIOUS_S:
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
    """Return the threads of a process; an unreadable one counts with zero times."""
    threads = {}
    with suppress(OSError):
        for name in os.listdir(f"/proc/{pid}/task"):  # noqa: PTH208 - importing pathlib takes too long
            with suppress(OSError, ValueError, IndexError):
                state = _read(f"/proc/{pid}/task/{name}/stat").rpartition(b")")[2].split()[0].decode()
                ran, waited = (0, 0)
                with suppress(OSError):  # a kernel without these counters
                    ran, waited = map(int, _read(f"/proc/{pid}/task/{name}/schedstat").split()[:2])
                threads[int(name)] = Thread(ran / 1e9, waited / 1e9, state)
    return threads


class Run:
    """The processes that the executive has started. Only processes of this user are searched for them."""

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
        """Return whether nothing is known to remain of ended processes."""
        return not self._left

    def hear(self, word: bytes) -> None:
        """Note the start or end of a process."""
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
        """End the remains of ended processes; repeat later for those that are not gone at once."""
        sessions = {session: number for number, session in self._left.items()}
        found = self._end(sessions, self._left) if sessions else []
        still = {sessions.get(one.session, one.number) for one in found}
        self._left = {number: session for number, session in self._left.items() if number in still}

    def end(self, done: Callable[[], object]) -> None:
        """Wait for processes to end by themselves, then kill the rest; return when only unkillable ones are left.

        Calls `done` repeatedly while only guards are left.
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
        """Wait until all processes that the executive itself has started are gone."""
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
        """Kill the processes of these sessions and with these marks (None: any mark); return those that may still
        exist.

        A process that forks faster than the search can only be killed by its group. A guard leads a group of its own.
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
        """Kill it, or continue it if it is a guard with time left; return whether it still has to be ended."""
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
        """Return a process in its present state, unless it is dead; unreadable facts count as absent."""
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
    """Return the text from the beginning of a variable to its end."""
    return environment.partition(b"\0" + variable)[2].partition(b"\0")[0]


def stay_awake(every_s: float) -> None:
    """Have the kernel continue this process at intervals, in case it is frozen: its writer may be frozen too."""
    import ctypes  # noqa: PLC0415 - takes 30 ms, in which the executive does not wait for this program

    class Event(ctypes.Structure):
        """`struct sigevent` of the C library; `way` 0 sends a signal at each expiry."""

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
    # newer kernels send an ignored signal only once
    signal.signal(signal.SIGCONT, lambda _number, _frame: None)


class Executive:
    """The executive that the reaper watches: its beats go to `silence`."""

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
        """Kill it if it hangs, and report why on its standard error, which then has no other writer."""
        if self._fd < 0 or not self.silence.hangs(time.monotonic(), lambda: threads_of(self._pid), self._pid):
            return False
        with suppress(OSError):
            signal.pidfd_send_signal(self._fd, signal.SIGKILL)
        still = f"stood still for {self._hangs_s:g} s: killed"
        say(f"reaper: the main loop of process {self._pid}, which runs the robot, {still}\n")
        return True


def say(text: str) -> None:
    """Write a line to standard error, unless that would block."""
    with suppress(OSError):
        blocking = os.get_blocking(2)
        os.set_blocking(2, False)  # only for this moment: a shell may share it
        try:
            os.write(2, text.encode())
        finally:
            os.set_blocking(2, blocking)


def main(mark: bytes, last_word: bytes, pid: bytes, hangs_s: bytes) -> None:
    """Read the executive's words for as long as it lives and beats, then end its remains."""
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
