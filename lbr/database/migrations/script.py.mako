"""${message}."""

import sqlalchemy as sa
from alembic import op

revision = ${repr(up_revision)}
down_revision = ${repr(down_revision)}


def upgrade() -> None:
    """Change the schema, in the transaction of the caller."""
    ${upgrades if upgrades else ""}


def downgrade() -> None:
    """Change nothing: an older database is kept as a backup whenever one is upgraded."""
