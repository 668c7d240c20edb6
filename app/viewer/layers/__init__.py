"""Further layers of the scene: feet, markers, modules, the centre of mass."""
