"""Who changed rows, and by what, stands beside their revisions; changes may be on trial."""

from alembic import op

revision = "0014"
down_revision = "0013"

BEFORE = """
INSERT INTO change (first_revision, last_revision, source, program, text)
SELECT 1, max(id), '', '', 'before lbr kept who it was' FROM revision HAVING max(id) IS NOT NULL
"""
STATEMENTS = (
    """
CREATE TABLE change (
    first_revision INTEGER NOT NULL PRIMARY KEY,  -- its first revision
    last_revision  INTEGER NOT NULL               -- its last one
        CHECK (last_revision >= first_revision),
    source         TEXT NOT NULL,                 -- who: an account here, a capability, or who asked at a page
    program        TEXT NOT NULL,                 -- by what: lbr db rollback, executive ...
    text           TEXT NOT NULL DEFAULT ''       -- what for, in one sentence
) STRICT
    """,
    """
CREATE TABLE trial (
    revision INTEGER NOT NULL PRIMARY KEY,  -- the last revision that is on trial
    back     INTEGER NOT NULL               -- the revision to go back to
        CHECK (back >= 0),
    robot    TEXT    NOT NULL,              -- whose executive judges
    within_s REAL    NOT NULL               -- how long it may take
        CHECK (within_s > 0 AND within_s <= 600),
    state    TEXT    NOT NULL DEFAULT 'running'  -- what became of it
        CHECK (state IN ('running', 'kept', 'back', 'lost')),
    text     TEXT    NOT NULL DEFAULT ''    -- why, in one sentence
) STRICT
    """,
    BEFORE,
)


def upgrade() -> None:
    """Add the tables; of what was changed until now it is not known who did it."""
    for statement in STATEMENTS:
        op.execute(statement)


def downgrade() -> None:
    """Change nothing: an older database is kept as a backup whenever one is upgraded."""
