"""What a finished fit lacks: which effects of the library its records ask for, and which they cannot tell apart."""
