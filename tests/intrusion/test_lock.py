"""What is released is locked by hash, and the lock is what the project asks for."""

import pytest

from tests.intrusion.dependencies import LOCK, ROOT, problems
from tests.support import programs

PROJECT = (ROOT / "pyproject.toml").read_text()


def test_the_lock_fits_the_project():
    assert problems(LOCK.read_text(), PROJECT) == [], "requirements/make lock"


@pytest.mark.parametrize(
    ("before", "after", "words"),
    [
        ("click==8", "click==7.", "asked for, locked is 7"),
        ("sha256:", "md5:", "not by hash"),
        ("msgspec==", "messagespec==", "needed and not locked"),
    ],
)
def test_a_lock_that_does_not_fit_is_told(before, after, words):
    assert words in " ".join(problems(LOCK.read_text().replace(before, after, 1), PROJECT))


def test_a_new_dependency_must_be_locked():
    project = PROJECT.replace('"click>=8.1"', '"click>=8.1", "hypothesis"')
    assert any("hypothesis is asked for" in text for text in problems(LOCK.read_text(), project))


def test_what_is_made_from_the_lock_says_what_it_makes():
    done = programs.run([ROOT / "requirements" / "make"], capture_output=True, text=True, check=False)
    assert done.returncode == 2
    assert "sbom" in done.stderr
