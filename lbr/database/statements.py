"""SQL statements for tables and columns of any name. `?` binds the values, in the order of the names."""

from collections.abc import Iterable


def select(table: str, columns: Iterable[str] = (), order: Iterable[str] = ()) -> str:
    """Return the statement that reads some columns, or all, in an order."""
    statement = f"SELECT {_listed(columns) or '*'} FROM {quoted(table)}"
    return f"{statement} ORDER BY {_listed(order)}" if order else statement


def insert(table: str, columns: Iterable[str]) -> str:
    """Return the statement that writes a new row."""
    names = tuple(columns)
    return f"INSERT INTO {quoted(table)} ({_listed(names)}) VALUES ({', '.join('?' * len(names))})"


def update(table: str, columns: Iterable[str], key: Iterable[str]) -> str:
    """Return the statement that changes columns of the row with a key. The values of the key come last."""
    return f"UPDATE {quoted(table)} SET {', '.join(_bound(columns))} WHERE {' AND '.join(_bound(key))}"


def delete(table: str, key: Iterable[str]) -> str:
    """Return the statement that deletes the row with a key."""
    return f"DELETE FROM {quoted(table)} WHERE {' AND '.join(_bound(key))}"


def quoted(name: str) -> str:
    """Return any name, quoted for SQL."""
    return '"' + name.replace('"', '""') + '"'


def _listed(names: Iterable[str]) -> str:
    return ", ".join(map(quoted, names))


def _bound(names: Iterable[str]) -> list[str]:
    return [f"{quoted(name)} = ?" for name in names]
