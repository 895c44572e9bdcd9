"""A canvas of Braille dots: 2 by 4 to a character, about square in a terminal."""

from collections.abc import Sequence

_BITS = ((0x01, 0x08), (0x02, 0x10), (0x04, 0x20), (0x40, 0x80))


class Canvas:
    """Dots, and letters over them; points outside are not drawn."""

    def __init__(self, columns: int, rows: int) -> None:
        self.width, self.height = columns * 2, rows * 4
        self._cells = [[0] * columns for _ in range(rows)]
        self._letters: dict[tuple[int, int], str] = {}

    def dot(self, x: float, y: float) -> None:
        """Set one dot."""
        if 0 <= x < self.width and 0 <= y < self.height:
            self._cells[int(y) // 4][int(x) // 2] |= _BITS[int(y) % 4][int(x) % 2]

    def line(self, start: tuple[float, float], end: tuple[float, float], every: int = 1) -> None:
        """Draw a line, or only each `every`-th of its dots."""
        steps = max(1, round(max(abs(end[0] - start[0]), abs(end[1] - start[1]))))
        for step in range(0, min(steps, 10_000) + 1, every):
            part = step / steps
            self.dot(start[0] + (end[0] - start[0]) * part, start[1] + (end[1] - start[1]) * part)

    def outline(self, corners: Sequence[tuple[float, float]], every: int = 1) -> None:
        """Draw a closed line, or only each `every`-th of its dots."""
        for index, corner in enumerate(corners):
            self.line(corners[index - 1], corner, every)

    def letter(self, x: float, y: float, letter: str) -> None:
        """Put a character over the dots."""
        if 0 <= x < self.width and 0 <= y < self.height:
            self._letters[int(x) // 2, int(y) // 4] = letter

    def lines(self) -> list[str]:
        """Return the picture as text, one string to a row."""
        return [
            "".join(self._letters.get((column, row)) or chr(0x2800 + cell) for column, cell in enumerate(cells))
            for row, cells in enumerate(self._cells)
        ]
