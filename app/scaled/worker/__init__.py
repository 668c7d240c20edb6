"""What sessions are live in: reads partitions of the stream that it holds, and publishes what it finds."""
