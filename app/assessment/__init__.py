"""Templates from recorded sessions, and comparison of a patient's repetitions with them."""
