"""The kernel's counted figures, a few of each; `python -m benchmarks motion` counts them all."""

import pytest

from tests.models.motion.counted import FIGURES


@pytest.mark.parametrize(("figure", "n"), [("F1", 300), ("F2", 600), ("F3", 3000), ("S18", 20)])
@pytest.mark.parametrize("seed", [1, 2])
def test_a_figure_that_is_counted_has_no_exception(figure, n, seed):
    count, _ = FIGURES[figure]
    counted = count(n, seed)
    assert counted.tried >= n
    assert counted.problems == []
