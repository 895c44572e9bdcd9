"""Tokens and their roles: the table `user_token`, which has hashes, never the tokens themselves."""

import msgspec

from lbr.database.connection import Connection, insert, selected
from lbr.database.rows import TokenRow
from lbr.errors import InputError
from lbr.messages.plain import one_line


def tokens(connection: Connection) -> tuple[TokenRow, ...]:
    """Return every token by name, including revoked and expired ones."""
    return tuple(TokenRow(**row) for row in selected(connection, "user_token", "1 ORDER BY name"))


def revoked(connection: Connection) -> set[str]:
    """Return the names of revoked tokens; for a database of any schema, as no newer column is read."""
    return {name for (name,) in connection.execute("SELECT name FROM user_token WHERE revoked_at IS NOT NULL")}


def add(connection: Connection, row: TokenRow) -> None:
    """Store a token; a revoked one of this name is replaced, a valid one raises InputError."""
    connection.execute("DELETE FROM user_token WHERE name = ? AND revoked_at IS NOT NULL", (row.name,))
    if connection.scalar("SELECT name FROM user_token WHERE name = ?", (row.name,)) is not None:
        raise InputError(f"there is a token '{row.name}' already: name another, or revoke it first")
    insert(connection, "user_token", [msgspec.structs.asdict(row)])


def rename(connection: Connection, name: str, called: str) -> None:
    """Store a token's name for people; raise InputError for an unknown token, or an empty name."""
    if not (plain := one_line(called).strip()):
        raise InputError("a name has a letter at least", "bad_value")
    if connection.execute("UPDATE user_token SET called = ? WHERE name = ?", (plain, name)).rowcount != 1:
        raise InputError(f"there is no token '{name}'", "unknown_name")


def revoke(connection: Connection, name: str, now: str) -> None:
    """Revoke a token; raise InputError if no valid token has this name."""
    valid = "UPDATE user_token SET revoked_at = ? WHERE name = ? AND revoked_at IS NULL"
    if connection.execute(valid, (now, name)).rowcount != 1:
        raise InputError(f"there is no token '{name}' that could be revoked", "unknown_name")
