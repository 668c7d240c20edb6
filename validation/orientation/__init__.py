"""Orientation of single sensors: BROAD, covariance, honesty, recordings turned wrong."""
