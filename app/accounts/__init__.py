"""Clinics, people, roles, sign-in, device tokens, tickets, consent and audit."""
