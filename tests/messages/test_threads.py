"""Several threads of a process decode messages, also those of a type that none has decoded before."""

import sys

from tests.support import programs

FIRST_USES = """
import sys, threading
import msgspec

FIELDS = [("value_%d" % n, float | None, None) for n in range(8)]
DATA = b'{"part_0": {"value_7": 2.0}, "part_5": {"value_3": 1.0}}'

sys.setswitchinterval(1e-6)
for number in range(50):
    part = msgspec.defstruct(f"Part{number}", FIELDS)
    whole = msgspec.defstruct(f"Whole{number}", [("part_%d" % n, part | None, None) for n in range(6)])
    together = threading.Barrier(3)

    def decode():
        together.wait()
        assert msgspec.json.decode(DATA, type=whole).part_5.value_3 == 1.0

    threads = [threading.Thread(target=decode) for _ in range(3)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
"""


def test_threads_that_decode_a_type_for_the_first_time_at_once_crash_nothing():
    done = programs.run([sys.executable, "-c", FIRST_USES], capture_output=True, text=True, check=False)
    assert (done.returncode, done.stderr) == (0, "")
