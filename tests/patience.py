"""How long a test waits for what must come.

It ends a run that hangs, and says nothing about speed: many tests share two slow cores, and how fast something comes is
measured in `tests/benchmarks`.
"""

PATIENCE_S = 300.0
PATIENCE_MS = 120_000.0
"""Of a browser page; a test of pages has many such waits."""
