"""A machine that gives no more threads is told of in one sentence."""

import pytest

from lbr.errors import LbrError
from lbr.executive import start


def test_a_thread_that_cannot_be_started_is_one_sentence_with_its_cure(tmp_path, monkeypatch):
    def no_thread(*_values, **_named):
        raise RuntimeError("can't start new thread")

    monkeypatch.setenv("LBR_HOME", str(tmp_path))
    tmp_path.chmod(0o700)
    monkeypatch.setattr(start, "Executive", no_thread)
    with pytest.raises(LbrError, match="free some memory, or have the limits raised"):
        start.run("lbr-sim", console=False)
