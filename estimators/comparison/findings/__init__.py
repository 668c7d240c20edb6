"""Findings in words: what is drawn outside the band, where places differ, and the one sentence for each fault."""
