"""Another machine may run a share of the robot: a token for it has the role `host`."""

from alembic import op

revision = "0005"
down_revision = "0004"

STATEMENTS = (
    "ALTER TABLE user_token RENAME TO former_user_token",
    """
CREATE TABLE user_token (
    name       TEXT NOT NULL PRIMARY KEY  -- whose it is
        CHECK (length(name) BETWEEN 1 AND 40),
    role       TEXT NOT NULL              -- look, move, change, or run a share of the robot
        CHECK (role IN ('view', 'operate', 'admin', 'host')),
    hash       TEXT NOT NULL              -- of the token
        CHECK (length(hash) >= 32),
    created_at TEXT NOT NULL DEFAULT (strftime('%Y-%m-%dT%H:%M:%fZ', 'now')),  -- when
    revoked_at TEXT,                      -- NULL: valid
    expires_at TEXT                       -- NULL: never
) STRICT
    """,
    """
INSERT INTO user_token (name, role, hash, created_at, revoked_at, expires_at)
SELECT name, role, hash, created_at, revoked_at, expires_at FROM former_user_token
    """,
    "DROP TABLE former_user_token",
)


def upgrade() -> None:
    """Make the table again: SQLite changes no check of a table that is there."""
    for statement in STATEMENTS:
        op.execute(statement)


def downgrade() -> None:
    """Change nothing: an older database is kept as a backup whenever one is upgraded."""
