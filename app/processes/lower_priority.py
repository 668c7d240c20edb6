"""Imported first by the process that children are forked from, and by nothing else: all of them inherit its low
priority.
"""

import os

NICENESS = 10

os.nice(NICENESS)
