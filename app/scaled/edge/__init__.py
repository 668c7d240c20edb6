"""What gateways and browsers reach: takes packets into the stream, shows what workers publish."""
