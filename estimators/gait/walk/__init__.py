"""A walk from the strides of both feet, beside their numbers."""
