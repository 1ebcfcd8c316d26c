"""Diagnosis of a finished fit: effects that the data support, and effects that the records cannot separate."""
