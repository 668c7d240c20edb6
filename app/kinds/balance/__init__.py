"""Balance tests: quiet standing and reaching, with sensors on pelvis and chest."""
