"""Run by alembic: applies the changes on the connection that `Database.migrate` hands over."""

from alembic import context

from server.storage.tables import Base


def run_migrations() -> None:
    """Apply what is missing, inside the caller's transaction."""
    connection = context.config.attributes["connection"]
    context.configure(connection=connection, target_metadata=Base.metadata, render_as_batch=True)
    context.run_migrations()


run_migrations()
