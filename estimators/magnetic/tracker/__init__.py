"""The three-coil tracker of Roetenberg 2006, chapter 5, and its fusion with inertial sensing, chapter 6."""
