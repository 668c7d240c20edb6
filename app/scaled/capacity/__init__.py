"""The capacity of a service on many machines, by the measured costs of its parts; see `docs/scaling.md`."""
