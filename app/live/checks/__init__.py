"""What is watched in a stream: link, health, readings that cannot be right."""
