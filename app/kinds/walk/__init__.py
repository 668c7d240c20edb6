"""Walks: feet followed by a filter of their own, with forces where the shoes measure them."""
