"""The kernel a command is about to use, and what compiling or loading it took, said as what it is."""

from __future__ import annotations

import typer

from mechid.kernel.compiled import Kernel, is_compiled, kernel_for
from mechid.plant.plant import Plant


def prepare_kernel(plant: Plant, sensitivities: int = 0) -> Kernel:
    """Return the compiled kernel of a plant; what it took is said on stderr."""
    if not is_compiled(plant, sensitivities):
        typer.echo("compiling the kernel (first time, cached afterwards) ...", err=True, nl=False)
        kernel = kernel_for(plant, sensitivities)
        typer.echo(f" {kernel.seconds:.1f} s", err=True)
        return kernel
    kernel = kernel_for(plant, sensitivities)
    typer.echo(f"kernel loaded from the cache in {kernel.seconds:.2f} s", err=True)
    return kernel
