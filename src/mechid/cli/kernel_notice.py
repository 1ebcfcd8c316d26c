"""Preparation of kernels before a command, with a notice of the time for compiling or loading."""

from __future__ import annotations

import typer

from mechid.campaign import Campaign
from mechid.kernel.compiled import Kernel, is_compiled, kernel_for
from mechid.kernel.source import lanes_for
from mechid.plant.plant import Plant


def prepare_kernels(campaign: Campaign) -> None:
    """Compile or load the kernels for an identification of the campaign."""
    from mechid.identification.uncertainty.visibility import count_sensitivities

    plant = campaign.mechanism.plant
    # For simulations without derivatives, as in a validation.
    prepare_kernel(plant)
    count = count_sensitivities(campaign)
    if lanes_for(count) > lanes_for(0):
        prepare_kernel(plant, count)


def prepare_kernel(plant: Plant, sensitivities: int = 0) -> Kernel:
    """Return the compiled kernel of a plant, and print the time on stderr."""
    if not is_compiled(plant, sensitivities):
        return _compile_kernel(plant, sensitivities)
    kernel = kernel_for(plant, sensitivities)
    typer.echo(f"kernel loaded from the cache in {kernel.seconds:.2f} s", err=True)
    return kernel


def _compile_kernel(plant: Plant, sensitivities: int) -> Kernel:
    typer.echo("compiling the kernel (first time, cached afterwards) ...", err=True, nl=False)
    took = ""
    try:
        kernel = kernel_for(plant, sensitivities)
        took = f" {kernel.seconds:.1f} s"
    finally:
        typer.echo(took, err=True)
    return kernel
