"""The pooled engine: packets of all live sessions of a kind in one compiled call a turn."""
