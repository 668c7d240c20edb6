"""Live sessions: from packets to frames as they come, and who steers and watches them.

`LiveManager` (`app.live.manager`) is made and started in the lifespan, on a `MemoryBus` (`app.live.bus`).
Nothing is imported here, so that the wire types in `app.live.messages` stay light.
"""
