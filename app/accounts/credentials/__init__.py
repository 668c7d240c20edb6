"""Passwords, second factors, tickets, and signing in by them."""
