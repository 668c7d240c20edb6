"""Random worlds for orientation filters and smoothers, drawn from what people, sensors and rooms do."""

from validation.worlds.conditions import Conditions, conditions_of
from validation.worlds.world import TUNING_SEEDS, World, draw, world_seed

__all__ = ["TUNING_SEEDS", "Conditions", "World", "conditions_of", "draw", "world_seed"]
