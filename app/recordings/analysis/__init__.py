"""Long tasks over stored sessions, and the general way through one."""
