"""Runs the migrations on the connection, and in the transaction, that the caller has put into the configuration."""

from alembic import context

from lbr.database.models import METADATA

context.configure(
    connection=context.config.attributes["connection"],
    target_metadata=METADATA,
    transactional_ddl=True,
)
context.run_migrations()
