"""Outputs of whole commands, and the films that they are made of."""
