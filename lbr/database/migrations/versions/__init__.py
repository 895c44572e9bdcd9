"""The changes of the schema."""
