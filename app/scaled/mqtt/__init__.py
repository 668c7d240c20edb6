"""Gateways that come by MQTT, through the NATS servers' own listener; see decision 0014."""
