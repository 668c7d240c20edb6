"""A course of therapy: what values are compared with, what happened meanwhile, and the report of it all."""
