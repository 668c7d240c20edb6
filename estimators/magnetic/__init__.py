"""Relative pose from body-worn magnetic sources."""
