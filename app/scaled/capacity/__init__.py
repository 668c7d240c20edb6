"""What a service on many machines carries, by the measured costs of its parts; see `docs/scaling.md`."""
