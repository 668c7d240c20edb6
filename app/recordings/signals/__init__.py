"""The signal store: packets and frames as rows of bits, written by one writer."""
