"""An address as a QR code: to hold a phone's camera at."""

import io
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import segno

BORDER = 4


def drawing(content: str) -> bytes:
    """Return it as SVG."""
    out = io.BytesIO()
    _made(content).save(out, kind="svg", scale=8, border=BORDER, light="#fff", xmldecl=False)
    return out.getvalue()


def characters(content: str) -> str:
    """Return it for a terminal with light letters on a dark ground: half blocks, and nothing but."""
    out = io.StringIO()
    _made(content).terminal(out, border=2, compact=True)
    return out.getvalue().rstrip("\n")


def _made(content: str) -> "segno.QRCode":
    import segno

    return segno.make(content, error="m", micro=False)
