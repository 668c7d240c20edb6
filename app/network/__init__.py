"""The body network: packets, their clock, what a gateway declares, and one common tick. No database."""
