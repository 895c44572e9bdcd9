"""By which address a token was given for a code."""

from alembic import op

revision = "0011"
down_revision = "0010"


def upgrade() -> None:
    """Add the column: tokens from before were made by hand."""
    op.execute(
        """
ALTER TABLE user_token ADD COLUMN paired_from TEXT
    CHECK (paired_from IS NULL OR length(paired_from) BETWEEN 1 AND 64)
        """
    )


def downgrade() -> None:
    """Change nothing: an older database is kept as a backup whenever one is upgraded."""
