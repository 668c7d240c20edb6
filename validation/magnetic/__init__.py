"""The magnetic tracker and its fusion (Roetenberg 2006, chapters 5 and 6; Schepers 2010, chapter 5)."""
