"""Forces, ankle power and centre of mass (Schepers 2010, chapters 2 and 4)."""
