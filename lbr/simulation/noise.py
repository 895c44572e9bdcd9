"""Noise that is a function of seed, sensor and step, so that reading one sensor changes nothing for the others."""

from zlib import crc32

import numpy as np
from numpy.typing import NDArray

_BLOCK = 1024

Floats = NDArray[np.float64]


class Noise:
    """Normally distributed vectors of one sensor, one to each step."""

    def __init__(self, seed: int, sensor: str, width: int) -> None:
        self._key = (seed & 0xFFFFFFFF, crc32(sensor.encode()))
        self._width = width
        self._number = -1
        self._block: Floats = np.zeros((0, width))

    def at(self, step: int) -> Floats:
        """Return the vector of a step, of standard deviation 1."""
        number, row = divmod(step, _BLOCK)
        if number != self._number:
            random = np.random.default_rng((*self._key, number))
            self._number, self._block = number, random.standard_normal((_BLOCK, self._width))
        vector: Floats = self._block[row]
        return vector
