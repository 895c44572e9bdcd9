"""An address as a QR code, to be scanned by a phone."""

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
    """Return it for a terminal with light letters on a dark ground, as half blocks alone."""
    out = io.StringIO()
    _made(content).terminal(out, border=2, compact=True)
    return out.getvalue().rstrip("\n")


def _made(content: str) -> "segno.QRCode":
    import segno

    return segno.make(content, error="m", micro=False)
