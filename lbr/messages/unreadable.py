"""What bytes raise that are no message."""

import msgspec

UNREADABLE = (msgspec.MsgspecError, UnicodeDecodeError, RecursionError)
"""From decoding JSON: it is none, not of that type, holds bytes that are no text, or is nested too deeply."""
