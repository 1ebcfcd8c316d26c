"""``mechid report``: the report of an identification, made anew."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer


def report(
    folder: Annotated[Path, typer.Argument(metavar="DIR", help="Result folder of mechid identify or demo.")],
    campaign: Annotated[
        Path | None, typer.Option(metavar="CAMPAIGN", help="Its campaign.toml; the journal's without it.")
    ] = None,
) -> None:
    """Make the report of an identification anew."""
    from mechid.analysis import validate
    from mechid.campaign import load_campaign
    from mechid.cli.kernel_notice import prepare_kernels
    from mechid.holding import held
    from mechid.identification.result.estimate_file import FILE_NAME
    from mechid.identification.result.fit_file import read_fit
    from mechid.identification.result.journal_file import identified_campaign
    from mechid.interface.finished_fit import completed_file
    from mechid.reports import read_truth, report_data
    from mechid.reports.illustration import Illustration
    from mechid.reports.pens import Pens
    from mechid.reports.results import write_components, write_residual
    from mechid.reports.terminal import console_on, print_lines
    from mechid.reports.writing import write_report

    synthetic, truth = read_truth(folder)
    with held(folder):
        path = campaign or identified_campaign(folder)
        loaded = load_campaign(path, mechanism_file=completed_file(folder))
        fit = read_fit(folder / FILE_NAME, loaded)
        prepare_kernels(loaded)
        with Pens() as pens:
            illustration = Illustration(loaded, fit, folder, pens)
            validation = validate(loaded, fit, illustration.begin)
            data = report_data(fit, truth, synthetic=synthetic, validation=validation)
            files = write_report(data, loaded, fit, validation, folder, illustration)
        files += [write_residual(fit, validation, folder)]
        files += write_components(fit, validation, folder)
        print_lines(console_on(), "written", [str(path) for path in files])
