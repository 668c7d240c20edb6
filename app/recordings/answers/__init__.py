"""A patient's answers after an exercise: pain, effort, a question of the therapist's, and words."""
