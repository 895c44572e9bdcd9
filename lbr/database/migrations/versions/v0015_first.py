"""The first schema: what robot.db.sql builds."""

revision = "0015"
down_revision = None


def upgrade() -> None:
    """Change nothing: there is no older schema, and robot.db.sql builds this one already stamped."""


def downgrade() -> None:
    """Change nothing: an older database is kept as a backup whenever one is upgraded."""
