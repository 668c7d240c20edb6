"""Relative pose by a worn magnetic source: confirmed to be safe, smoothed as a whole, with its bench and its use."""
