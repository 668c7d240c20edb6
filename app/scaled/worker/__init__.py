"""The worker that sessions are live in: it reads the partitions that it holds, and publishes its results."""
