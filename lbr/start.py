"""The command `lbr`: Ctrl-C counts from its first moment on, also while it is still loaded."""

INTERRUPTED = 130


def main() -> int:
    """Run `lbr`; return its exit code."""
    try:
        from lbr.cli import main as run  # noqa: PLC0415 - loading it takes a fifth of a second
    except KeyboardInterrupt:
        return INTERRUPTED
    return run()
