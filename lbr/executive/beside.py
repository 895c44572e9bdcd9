"""Threads beside the main loop. A machine that gives no more of them for a moment ends no robot."""

import threading
from collections.abc import Callable

NO_THREAD = "this machine gives no more threads now: free some memory, or have the limits raised"


def begin(run: Callable[[], object], name: str) -> threading.Thread | None:
    """Run it beside the caller; None if this machine gives no more threads."""
    thread = threading.Thread(target=run, name=name, daemon=True)
    try:
        thread.start()
    except RuntimeError:
        return None
    return thread
