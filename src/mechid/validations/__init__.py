"""Presentation of a validation: numbers, tables and document."""
