"""One live session: from packets to frames."""
