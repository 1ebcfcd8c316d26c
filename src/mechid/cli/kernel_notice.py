"""The kernel a command is about to use, and what compiling or loading it took, said as what it is."""

from __future__ import annotations

import typer

from mechid.campaign import Campaign
from mechid.kernel.compiled import Kernel, is_compiled, kernel_for
from mechid.kernel.source import lanes_for
from mechid.plant.plant import Plant


def prepare_kernels(campaign: Campaign) -> None:
    """Compile or load what an identification of the campaign needs."""
    from mechid.identification.uncertainty.visibility import count_sensitivities

    plant = campaign.mechanism.plant
    prepare_kernel(plant)  # of runs without derivatives, as those of a validation
    count = count_sensitivities(campaign)
    if lanes_for(count) > lanes_for(0):
        prepare_kernel(plant, count)


def prepare_kernel(plant: Plant, count_sensitivities: int = 0) -> Kernel:
    """Return the compiled kernel of a plant; what it took is said on stderr."""
    if not is_compiled(plant, count_sensitivities):
        return _compiled_now(plant, count_sensitivities)
    kernel = kernel_for(plant, count_sensitivities)
    typer.echo(f"kernel loaded from the cache in {kernel.seconds:.2f} s", err=True)
    return kernel


def _compiled_now(plant: Plant, count_sensitivities: int) -> Kernel:
    typer.echo("compiling the kernel (first time, cached afterwards) ...", err=True, nl=False)
    took = ""
    try:
        kernel = kernel_for(plant, count_sensitivities)
        took = f" {kernel.seconds:.1f} s"
    finally:
        typer.echo(took, err=True)
    return kernel
