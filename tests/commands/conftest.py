from pathlib import Path

import pytest

from tests.support import databases


@pytest.fixture
def path(tmp_path, monkeypatch) -> Path:
    monkeypatch.setenv("LBR_HOME", str(tmp_path / "home"))
    return databases.in_home(tmp_path / "home")
