"""Arms and trunk: calibrated by a pose or movements, smoothed off-line, joint angles against a template."""
