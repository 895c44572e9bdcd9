"""Text from foreign sources, before it is shown or stored."""


def one_line(text: str) -> str:
    """Return a text as one printable line of any length."""
    return text if text.isprintable() else "".join(c if c.isprintable() else " " for c in text)
