#!/usr/bin/env python3
"""usage: images.py TOOL

Draws the pictures of docs/images anew from today's runs. Needs gnuplot.
"""
import pathlib
import subprocess
import sys

IMAGES = pathlib.Path(__file__).parents[2] / "docs/images"
SCENARIO_OF = {"run": "main", "dtp": "dtp", "dtp_open_phase": "dtp_open_phase",
               "zero_reversal": "zero_reversal", "zero_learn": "zero_learn"}


def main():
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    for name, scenario in SCENARIO_OF.items():
        picture = IMAGES / f"{name}.svg"
        subprocess.run([sys.argv[1], "run", scenario, "--plot", picture], check=True, stdout=subprocess.DEVNULL)
        print(f"written: {picture}")


if __name__ == "__main__":
    main()
