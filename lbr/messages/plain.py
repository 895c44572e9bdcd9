"""Text from foreign sources, before it is shown, told or written down."""


def one_line(text: str) -> str:
    """Return a text as one printable line of any length."""
    return text if text.isprintable() else "".join(c if c.isprintable() else " " for c in text)
