"""Who may do what: the table `user_token`. The tokens themselves are never here, only their hashes."""

from sqlalchemy import Connection, insert, select, update
from sqlalchemy import delete as delete_from

from lbr.database.models import USER_TOKEN
from lbr.database.rows import TokenRow
from lbr.errors import InputError


def tokens(connection: Connection) -> tuple[TokenRow, ...]:
    """Return every token, revoked and expired ones too, by name."""
    rows = connection.execute(select(USER_TOKEN).order_by(USER_TOKEN.c.name)).mappings()
    return tuple(TokenRow(**row) for row in rows)


def revoked(connection: Connection) -> set[str]:
    """Return the names of those that were revoked; of a database of any schema, because no newer column is read."""
    return set(connection.scalars(select(USER_TOKEN.c.name).where(USER_TOKEN.c.revoked_at.is_not(None))))


def add(connection: Connection, row: TokenRow) -> None:
    """Write a token down; one of this name that was revoked makes room, a valid one is an InputError."""
    revoked = (USER_TOKEN.c.name == row.name) & USER_TOKEN.c.revoked_at.is_not(None)
    connection.execute(delete_from(USER_TOKEN).where(revoked))
    if connection.scalar(select(USER_TOKEN.c.name).where(USER_TOKEN.c.name == row.name)) is not None:
        raise InputError(f"there is a token '{row.name}' already: name another, or revoke it first")
    connection.execute(
        insert(USER_TOKEN).values(
            name=row.name,
            role=row.role,
            hash=row.hash,
            created_at=row.created_at,
            expires_at=row.expires_at,
            good_for=row.good_for,
        )
    )


def revoke(connection: Connection, name: str, now: str) -> None:
    """Take a token's rights away; raise InputError if there is none of this name that has any."""
    valid = (USER_TOKEN.c.name == name) & USER_TOKEN.c.revoked_at.is_(None)
    if connection.execute(update(USER_TOKEN).where(valid).values(revoked_at=now)).rowcount != 1:
        raise InputError(f"there is no token '{name}' that could be revoked", "unknown_name")
