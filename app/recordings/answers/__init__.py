"""What a patient says after an exercise: pain, effort, a question of the therapist's, and words."""
