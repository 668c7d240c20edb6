"""Three forward kinematics of one chain of segments (Marzouk 2009, chapter 4)."""
