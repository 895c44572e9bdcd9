"""A small terminal: what a person sees after bytes were written to it."""

import re

SEQUENCE = re.compile(r"\x1b\[([?0-9;]*)([A-Za-z~])|(.)", re.DOTALL)


class Vt:
    """Rows of characters with a cursor, automatic wrapping and scrolling, as xterm has them."""

    def __init__(self, rows: int, columns: int) -> None:
        self.columns = columns
        self.rows = [[" "] * columns for _ in range(rows)]
        self.row = self.column = 0
        self._wrap = True
        self._pending = False

    @property
    def lines(self) -> list[str]:
        return ["".join(row).rstrip() for row in self.rows]

    def feed(self, text: str) -> None:
        for numbers, final, char in SEQUENCE.findall(text):
            if final:
                self._control(numbers, final)
            else:
                self._put(char)

    def _put(self, char: str) -> None:
        if char == "\r":
            self.column, self._pending = 0, False
        elif char == "\n":
            self._feed()
        elif char == "\b":
            self.column, self._pending = max(0, self.column - 1), False
        elif char >= " ":
            if self._pending and self._wrap:
                self.column = 0
                self._feed()
            self.rows[self.row][self.column] = char
            self._pending = self.column == self.columns - 1
            self.column = min(self.column + 1, self.columns - 1)

    def _feed(self) -> None:
        self._pending = False
        if self.row < len(self.rows) - 1:
            self.row += 1
        else:
            self.rows = [*self.rows[1:], [" "] * self.columns]

    def _control(self, numbers: str, final: str) -> None:
        if final in "hl":
            self._wrap = final == "h" if numbers == "?7" else self._wrap
            return
        if final == "m" or numbers + final == "6n":
            return
        self._pending = False
        count = int(numbers or 1) if numbers.isdigit() or not numbers else 1
        if final in "AB":
            self.row = min(max(0, self.row + (count if final == "B" else -count)), len(self.rows) - 1)
        elif final in "CD":
            self.column = min(max(0, self.column + (count if final == "C" else -count)), self.columns - 1)
        elif final == "H" and not numbers:
            self.row = self.column = 0
        elif final in "JK":
            assert numbers in {"", "0"}, f"clearing {numbers}{final} is not known here"
            self.rows[self.row][self.column :] = [" "] * (self.columns - self.column)
            for row in self.rows[self.row + 1 :] if final == "J" else []:
                row[:] = [" "] * self.columns
        else:
            raise AssertionError(f"the sequence {numbers}{final} is not known here")
