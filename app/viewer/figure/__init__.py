"""The figure: body, ghost, and what they are made of."""
