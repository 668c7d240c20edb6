"""The demonstration clinic: invented people, past sessions made by the real chain, and a patient who streams live."""
