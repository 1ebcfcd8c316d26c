"""Stages of an identification: joint fits, release of the noise, held parameters, and stages of the campaign file."""
