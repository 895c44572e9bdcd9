"""Threads beside the main loop. A robot survives a machine that refuses to start one."""

import threading
from collections.abc import Callable

NO_THREAD = "this machine gives no more threads now: free some memory, or have the limits raised"


def begin(run: Callable[[], object], name: str) -> threading.Thread | None:
    """Run it in a thread of its own; return None if this machine starts no more threads."""
    thread = threading.Thread(target=run, name=name, daemon=True)
    try:
        thread.start()
    except RuntimeError:
        return None
    return thread
