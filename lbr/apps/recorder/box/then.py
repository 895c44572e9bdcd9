"""A recorded moment in the form that `why` explains."""

import msgspec

from lbr.apps.recorder.recording.moment import Moment
from lbr.errors import InputError
from lbr.messages.unreadable import UNREADABLE
from lbr.why.snapshot import Facts, Said, Snapshot

SILENT_S = 3.0
"""A robot that runs publishes something each second."""


def snapshot(moment: Moment) -> Snapshot:
    """Return the snapshot of a moment for `why`; raise InputError if its rows were not recorded."""
    if moment.rows is None:
        raise InputError("the rows of then are not in the recording, and without them nothing can be explained")
    try:
        facts = msgspec.json.decode(moment.rows.facts, type=Facts)
    except UNREADABLE as err:
        raise InputError(f"the rows of then are of another version: {err}") from None
    return Snapshot(
        facts=facts,
        executive="up" if moment.late_s <= SILENT_S else "down",
        status=moment.status,
        messages={topic: Said(message=message, age_s=age_s) for topic, (message, age_s) in moment.messages.items()},
        events=moment.events,
        wall_ns=moment.at_ns,
    )
