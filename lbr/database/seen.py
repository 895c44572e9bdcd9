"""The rows of all robots from one transaction, and the result of an edit of them: judged after the transaction."""

from typing import NamedTuple, Self

from msgspec.structs import replace

from lbr.database import adopted, tokens
from lbr.database.checks import check
from lbr.database.connection import Connection
from lbr.database.reading import Problem, RawTables
from lbr.database.rows import RobotRows, TokenRow
from lbr.database.tables import Schema, read_tables


class Seen(NamedTuple):
    """Tables and tokens of a revision, with the digest of the rows, and a problem if others ran as this revision."""

    tables: RawTables
    schema: Schema
    tokens: tuple[TokenRow, ...]
    revision: int
    digest: str
    problems: tuple[Problem, ...]

    @classmethod
    def by(cls, connection: Connection) -> Self:
        """Read them."""
        tables, schema = read_tables(connection)
        revision, digest = adopted.revision(connection), adopted.digest(tables)
        problems = adopted.problems(connection, revision, digest)
        return cls(tables, schema, tokens.tokens(connection), revision, digest, problems)

    def rows(self, robot: str, tables: RawTables | None = None) -> RobotRows:
        """Return a robot's rows, checked; from other `tables`, if they are given."""
        raw = self.tables if tables is None else tables
        checked = check(raw, robot, revision=self.revision, problems=self.problems, columns=self.schema)
        return replace(checked, tokens=self.tokens, digest=self.digest)
