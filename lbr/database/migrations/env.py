"""Runs the migrations on the connection, and in the transaction, that the caller has put into the configuration."""

from alembic import context

context.configure(connection=context.config.attributes["connection"], transactional_ddl=True)
context.run_migrations()
