"""What packages of others build on stays, unless somebody decides otherwise."""

import sys

import pytest

from tests.api.surface import PINNED, surface

pytestmark = pytest.mark.skipif(
    sys.version_info[:2] != (3, 11), reason="written with Python 3.11; others print types otherwise"
)
PINNED_LINES = PINNED.read_text(encoding="utf-8").splitlines()


def test_nothing_that_others_build_on_is_gone_or_changed():
    gone = set(PINNED_LINES) - set(surface())
    assert not gone, f"gone or changed, which breaks packages of others: {sorted(gone)}"


def test_what_is_new_for_others_is_written_down():
    new = set(surface()) - set(PINNED_LINES)
    assert not new, f"new; `python -m tests.api.surface` writes it down: {sorted(new)}"


def test_the_surface_has_signatures_fields_and_names():
    assert any(line.startswith("lbr.capability.Context.take(self, port: str)") for line in PINNED_LINES)
    assert any(line.startswith("lbr.messages.drive.DriveCommand.power: ") for line in PINNED_LINES)
    assert "component kinds: drive" in PINNED_LINES
