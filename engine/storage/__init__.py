"""Atomic writing, untrusted reading, archives, records and scratch space."""
