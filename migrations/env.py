"""Alembic runs on the connection that orient.store hands over, inside its one transaction; never on an own engine."""

from alembic import context

connection = context.config.attributes.get("connection")
if connection is None:
    raise SystemExit("migrations run through `orient new` and `orient upgrade` only, which lock and check the file")

context.configure(connection=connection, target_metadata=None, transaction_per_migration=False)
with context.begin_transaction():
    context.run_migrations()
