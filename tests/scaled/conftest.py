"""PostgreSQL as the tests of the service use it."""

from tests.app.conftest import postgresql_database as postgresql_database
