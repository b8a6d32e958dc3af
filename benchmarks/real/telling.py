"""What the programs on real data share: their one option, and the causes of a diagnosis as they print them."""

import argparse
import math

from octmip.gap import Diagnosis
from octmip.interfaces.report.diagnosis.phrases import cause_words, likely
from octmip.interfaces.report.diagnosis.recommendation import recommend


def picture_path(description: str | None) -> str | None:
    """Return the file that `--picture` names on the command line, None without it."""
    parser = argparse.ArgumentParser(description=description)
    parser.add_argument("--picture", metavar="FILE.png")
    path: str | None = parser.parse_args().picture
    return path


def show_causes(found: Diagnosis, unit: str = "") -> None:
    """Print verdict, causes of more than 2 %, inclusion of more than 5 %, chi-squared, the held-out share."""
    words = recommend(found)
    print(words.replace("microstrain", unit) if unit else words)
    for cause in found.which:
        if cause.probability > 0.02:
            print(f"  {likely(cause.probability):>12}  {cause_words(cause)}")
    print("  among the causes:", {name: round(p, 3) for name, p in found.inclusion.items() if p > 0.05})
    closing = found.shrinkage
    if closing is not None:
        print(
            f"  chi-squared per reading {closing.chi2_before:.3g} -> {closing.chi2_after:.3g}, chance of the rest "
            f"{closing.p_after:.2g}"
        )
        if not math.isnan(closing.closed):
            print(f"  held out: {closing.before:.1f} -> {closing.after:.1f}, closed {closing.closed:.3f}")
