"""Ports for servers of tests."""

import random
import socket

OURS = range(20_000, 32_768)
"""Below the ports that the system gives to outgoing connections: one of those could take ours first."""


def free_port() -> int:
    """Return a port of this machine on which nothing listens."""
    while True:
        port = random.SystemRandom().choice(OURS)
        with socket.socket() as probe:
            try:
                probe.bind(("127.0.0.1", port))
            except OSError:
                continue
        return port
