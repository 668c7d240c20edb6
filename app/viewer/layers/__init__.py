"""What else stands in the scene: feet, markers, modules, the centre of mass."""
