"""Rights of open sockets, checked again and again: asked for many sockets in one question."""
