"""The shapes of values: each as a CHECK of SQL, and in words for people."""

import re

from msgspec import Struct


class Shape(Struct, frozen=True):
    """A CHECK of a column `{x}` in SQL and `words`, by bounds `{a}` and `{b}`, a `{list}` or a column `{y}`."""

    sql: str
    words: str

    def __repr__(self) -> str:
        return f"Shape({self.words!r})"

    def check(self, x: str, **parts: str) -> str:
        """Return the CHECK of a column."""
        return self.sql.format(x=x, **parts)

    def allowed(self, check: str) -> tuple[str, str] | None:
        """Return the column of a CHECK of this shape, and the permitted values in words; None for another CHECK."""
        match = re.fullmatch(self._pattern(), check)
        if match is None:
            return None
        parts = {name: text.replace("'", "") for name, text in match.groupdict().items()}
        return parts["x"], re.sub(r"\{(\w+)\}", lambda part: parts.get(part[1], part[0]), self.words)

    def _pattern(self) -> str:
        """Return the regular expression of all such CHECKs."""
        pattern, known = "", set[str]()
        for number, part in enumerate(re.split(r"\{(\w+)\}", self.sql)):
            if number % 2 == 0:
                pattern += re.escape(part)
            elif part in known:
                pattern += f"(?P={part})"
            else:
                pattern += rf"(?P<{part}>.*)" if part == "list" else rf"(?P<{part}>[^\s()]+)"
                known.add(part)
        return pattern


_NAME = "{x} GLOB '[a-z]*' AND {x} NOT GLOB '*[^a-z0-9_]*' AND length({x}) <= 40"
NAME = Shape(_NAME, "a name (small letters, digits, underscores; at most 40)")
NAME_OR_NONE = Shape(f"{{x}} = '' OR ({_NAME})", f"{NAME.words}, or empty for none")
CAPABILITY_NAME = Shape(f"{_NAME} AND {{x}} <> 'executive'", f"{NAME.words} other than 'executive'")
PORT = Shape(
    "{x} GLOB '[a-z]*.[a-z]*' AND {x} NOT GLOB '*[^a-z0-9_.]*' AND {x} NOT GLOB '*.*.*'", "of the form capability.port"
)
WORD = Shape(
    "{x} GLOB '[A-Za-z]*' AND {x} NOT GLOB '*[^A-Za-z0-9_]*' AND length({x}) <= 40",
    "a word (letters, digits, underscores; at most 40)",
)
LANGUAGE = Shape(
    "{x} GLOB '[a-z][a-z]*' AND {x} NOT GLOB '*[^a-z0-9-]*' AND length({x}) <= 20",
    "a language tag in small letters, such as en",
)
PATTERN = Shape(
    "{x} = word OR {x} = '/' || word OR substr({x}, 1, length(word) + 2) = '/' || word || '/'",
    "the row's word, or a path that begins with it: /word/{field}",
)
OBJECT = Shape("json_valid({x}) AND json_type({x}) = 'object'", 'a JSON object like {"key": 1}')
LIST = Shape("json_valid({x}) AND json_type({x}) = 'array'", 'a JSON list like ["a", "b"]')
PROGRAM = Shape(f"{LIST.sql} AND json_array_length({{x}}) >= 1", f"{LIST.words}, and not an empty one")
ONE_OF = Shape("{x} IN ({list})", "one of {list}")
LENGTH = Shape("length({x}) BETWEEN {a} AND {b}", "{a} to {b} characters")
SHORTER = Shape("length({x}) <= {b}", "at most {b} characters")
LONGER = Shape("length({x}) >= {a}", "at least {a} characters")
WITHIN = Shape("{x} BETWEEN {a} AND {b}", "from {a} to {b}")
ABOVE = Shape("{x} > {a} AND {x} <= {b}", "above {a} and at most {b}")
AT_LEAST = Shape("{x} >= {a}", "at least {a}")
ASCENDING = Shape("{y} < {x}", "above {y}")
TOGETHER = Shape("({y} IS NULL) = ({x} IS NULL)", "NULL if {y} is, and only then")
SHAPES = tuple(shape for shape in list(globals().values()) if isinstance(shape, Shape))
