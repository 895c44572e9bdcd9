"""The schema after: tokens with names for people. Where a row shows the page, it offers recordings, too."""

from lbr.database.migrate import run

revision = "0016"
down_revision = "0015"
SCRIPT = r"""
-- The roles of people and machines. The token itself is shown once and never stored.
CREATE TABLE user_token_new (
    name        TEXT NOT NULL PRIMARY KEY  -- its owner
        CHECK (length(name) BETWEEN 1 AND 40),
    role        TEXT NOT NULL  -- look, move, change, or run a share of the robot
        CHECK (role IN ('view', 'operate', 'admin', 'host')),
    hash        TEXT NOT NULL  -- of the token
        CHECK (length(hash) >= 32),
    created_at  TEXT NOT NULL DEFAULT (strftime('%Y-%m-%dT%H:%M:%fZ', 'now')),  -- when
    revoked_at  TEXT,  -- NULL: valid
    expires_at  TEXT,  -- NULL: never
    good_for    TEXT NOT NULL DEFAULT 'both'  -- the doors that it opens
        CHECK (good_for IN ('bus', 'web', 'both')),
    paired_from TEXT  -- the address that paired; NULL: made by hand
        CHECK (paired_from IS NULL OR (length(paired_from) BETWEEN 1 AND 64)),
    called      TEXT  -- what people call it; NULL: by its name
        CHECK (called IS NULL OR (length(called) BETWEEN 1 AND 40))
) STRICT;
INSERT INTO user_token_new (name, role, hash, created_at, revoked_at, expires_at, good_for, paired_from)
SELECT name, role, hash, created_at, revoked_at, expires_at, good_for, paired_from FROM user_token;
DROP TABLE user_token;
ALTER TABLE user_token_new RENAME TO user_token;
UPDATE capability SET settings = json_insert(settings, '$.faces[#]', 'recordings') WHERE kind = 'web'
AND json_extract(settings, '$.faces') GLOB '*"page"*' AND json_extract(settings, '$.faces') NOT GLOB '*"recordings"*';
"""


def upgrade() -> None:
    """Change the schema, in the transaction of the caller."""
    run(SCRIPT)


def downgrade() -> None:
    """Change nothing: an older database is kept as a backup whenever one is upgraded."""
