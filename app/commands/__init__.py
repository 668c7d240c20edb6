"""What the commands of `app.cli` do; may import every room, nothing imports it."""
