"""How measurements come in: the packet, the socket and uploads."""
