"""Pose of a sensor relative to a magnetic source, by the filter of Schepers 2010, chapter 6."""
