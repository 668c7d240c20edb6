"""The commands of `app.cli`; they may import every room, nothing imports them."""
