"""The edge for gateways and browsers: takes packets into the stream, shows what workers publish."""
