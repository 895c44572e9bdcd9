"""Recordings that tests write by hand."""

from collections.abc import Iterator
from contextlib import contextmanager

from lbr.apps.recorder.recording.segments import Segment


@contextmanager
def finished(segment: Segment) -> Iterator[Segment]:
    """Yield a file under way, and finish it after the `with`."""
    yield segment
    segment.finish()
