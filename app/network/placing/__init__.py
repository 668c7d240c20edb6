"""Packets of many sessions to samples at common ticks, compiled."""
