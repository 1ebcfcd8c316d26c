"""Identify the model of a stepper-driven pointing mechanism from torque-transducer records."""

__version__ = "0.1.0"
