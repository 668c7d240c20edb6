"""A person who moves an arm: exercises, patients, repeated movements, with exact truth."""
