"""What strides of both feet tell of a walk beside their numbers."""
