"""The stages of an identification: joint fits, noise released, parameters held, or the user's own."""
