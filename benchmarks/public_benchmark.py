"""Public benchmark: makes its campaigns, enters three methods, and prints the table of the docs.

    python benchmarks/public_benchmark.py make --out FOLDER           # ten campaigns, within a minute
    python benchmarks/public_benchmark.py table --out FOLDER          # makes, enters all methods, prints the table
    python benchmarks/public_benchmark.py table --out FOLDER --methods mechid --campaigns 01 10
    python benchmarks/public_benchmark.py noise --out FOLDER --campaigns 01 --draws 15      # intervals of mechid
    python benchmarks/public_benchmark.py answers                           # packed answers of the package, renewed

An entry that is in the folder already is not repeated; a changed method wants a new folder.
"""

import argparse
import importlib
import importlib.util
import json
from collections.abc import Sequence
from pathlib import Path

from public.maker.sheets import answers, write_campaign
from public.mechid_benchmark.answers import read_answers, write_answers
from public.mechid_benchmark.scores import score_submission, table
from public.mechid_benchmark.submission import read_submission
from public.mechid_benchmark.tasks import CAMPAIGNS, FORMAT

OUT = Path("build/public")
METHODS = ("mechid", "scipy", "casadi")


def main() -> None:
    """Make campaigns, their answers, or the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("job", choices=["make", "table", "noise", "answers"])
    parser.add_argument("--campaigns", nargs="+", default=CAMPAIGNS, choices=CAMPAIGNS, metavar="NN")
    parser.add_argument("--methods", nargs="+", default=METHODS, choices=METHODS)
    parser.add_argument("--draws", type=int, default=15, help="noise draws of each campaign")
    parser.add_argument("--out", type=Path, default=OUT, help=f"folder to be continued, {OUT} by default")
    asked = parser.parse_args()
    if asked.job == "answers":
        write_answers(answers())
        return
    make(asked.out, asked.campaigns)
    if asked.job == "table":
        for method in asked.methods:
            if method == "casadi" and not importlib.util.find_spec("casadi"):
                print("casadi is left out: it is not installed (the extra `bench` brings it)", flush=True)
                continue
            score = score_submission(read_submission(enter(method, asked.out, asked.campaigns)), read_answers())
            print(f"\n{score['name']}\n\n{table(score)}", flush=True)
    if asked.job == "noise":
        for number in asked.campaigns:
            draw_noise(number, asked.out, asked.draws)


def make(out: Path, campaigns: Sequence[str]) -> None:
    """Write the campaigns that are not in the folder yet."""
    for number in campaigns:
        folder = out / f"campaign_{number}"
        if not (folder / "task.json").exists():
            write_campaign(number, folder)
            print(f"made {folder}", flush=True)


def enter(method: str, out: Path, campaigns: Sequence[str]) -> Path:
    """Enter a method in campaigns that it has not entered yet, and return the file of its submission."""
    module = importlib.import_module(f"public.entries.{method}_entry")
    file = out / f"{method}.json"
    told = json.loads(file.read_text()) if file.exists() else {"format": FORMAT, "name": module.NAME, "campaigns": {}}
    for number in campaigns:
        if number not in told["campaigns"]:
            told["campaigns"][number] = module.enter(out / f"campaign_{number}", out / method / number)
            file.write_text(json.dumps(told, indent=1) + "\n")
            print(f"{method}: campaign {number} entered", flush=True)
    return file


def draw_noise(number: str, out: Path, count: int) -> None:
    """Print how the intervals of mechid hold over noise draws of a campaign."""
    module = importlib.import_module("public.entries.noise_draws")  # mechid is needed for it alone
    found = []
    for one in module.draws(number, out / f"campaign_{number}", count):
        found.append(one)
        print(
            f"{number}, draw {len(found)}: {one.held} of {one.stated} hold, squared distance "
            f"{one.squared_distance:.1f}, p {one.p_value:.3f}; {one.remark}",
            flush=True,
        )
    print(f"{number}: {module.summary(found)}")


if __name__ == "__main__":
    main()
