"""Quiet drive: rates, stepping and microstep table with which an identified mechanism disturbs least."""
