"""The service on many machines: edges that sockets reach, workers that sessions are live in, NATS JetStream between.

`docs/scaling.md` says how it works. Nothing here is imported by the service in one process.
"""
