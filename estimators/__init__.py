"""The numerical library of Telemotion: arrays in, arrays out.

No I/O, no clock, no database, no asyncio: everything here can be used by a stranger on
recorded arrays. Frames, units and signs are defined once, in `estimators.conventions`.
"""
