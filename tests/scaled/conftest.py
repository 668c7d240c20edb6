"""PostgreSQL and accounts as the tests of the service use them."""

from tests.app.conftest import cheap_passwords as cheap_passwords
from tests.app.conftest import postgresql_database as postgresql_database
