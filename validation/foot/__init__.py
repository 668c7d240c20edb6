"""Foot placement and walks (Schepers 2010, chapter 3; PyShoe, gaitmap, x-io)."""
