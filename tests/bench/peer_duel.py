#!/usr/bin/env python3
"""Derivative images of this renderer and of Mitsuba 3 side by side, in one run on one machine.

peer_duel.py --bench BUILD/tests/gradient_bench --peer FOLDER [--python PYTHON] [--references DIR]
             [--cases NAME ...] [--rounds N] [--repeats N] [--out FILE.json]

FOLDER holds the peer's scripts (gradients.py, references.py) and scenes/. PYTHON is an interpreter with mitsuba;
without it only our side runs. DIR holds the derivative images that references.py has written. Every round runs all
settings of both sides in turn, so that what else the machine does hits them alike; seconds are medians over the
rounds, variances means. Efficiency is 1 / (variance x seconds), set-up and guide included.
"""
import argparse
import json
import os
import statistics
import subprocess
import sys
from pathlib import Path

CASES = ["soft_shadow", "bunny_direct", "bunny_two_bounces", "cornell_four_bounces"]
# Guiding and samples per pixel of the peer: its best ones, and those its published figures use.
PEER_SETTINGS = {
    "soft_shadow": [("octree", 256), ("none", 64)],
    "bunny_direct": [("octree", 256), ("none", 64)],
    "bunny_two_bounces": [("octree", 256), ("none", 64)],
    "cornell_four_bounces": [("octree", 64), ("grid", 64), ("none", 64)],
}
# Ours: form, spp, sppe, spp_direct, spp_indirect, spp_pixel, guide.
OUR_SETTINGS = {
    "soft_shadow": [("image", 1, 1, 64, 0, 0, "adaptive"), ("image", 1, 1, 64, 0, 0, "grid"),
                    ("image", 1, 1, 64, 0, 0, "none")],
    "bunny_direct": [("material", 16, 12, 16, 0, 64, "adaptive"), ("material", 16, 12, 16, 0, 64, "none"),
                     ("image", 64, 96, 16, 0, 0, "adaptive")],
    "bunny_two_bounces": [("material", 16, 12, 8, 2, 64, "adaptive"), ("image", 64, 48, 6, 2, 0, "adaptive")],
    "cornell_four_bounces": [("image", 64, 128, 4, 4, 0, "adaptive"), ("image", 64, 128, 4, 4, 0, "none"),
                             ("material", 64, 64, 4, 4, 64, "adaptive")],
}
# The setting that is compared with (None: the best unbiased one) and the ratio that is wanted.
TARGETS = {
    "soft_shadow": ("peer octree 256", 60.0), "bunny_direct": ("peer none 64", 8.0),
    "bunny_two_bounces": ("peer none 64", 40.0), "cornell_four_bounces": (None, 1000.0),
}
# Ours is biased if its z-scores against the references are wider than this, the peer's (of which only
# the mean square is known) if that differs from the references' by more than this share.
Z_RMS = 1.3
BIAS = 0.15


def run(command, environment=None):
    """The JSON lines a program prints."""
    done = subprocess.run(command, capture_output=True, text=True, env=environment, check=False)
    if done.returncode != 0:
        sys.exit(f"{' '.join(map(str, command))} failed:\n{done.stderr[-2000:]}")
    return [json.loads(line) for line in done.stdout.splitlines() if line.startswith("{")]


def peer_environment():
    environment = dict(os.environ, PYTHONDONTWRITEBYTECODE="1")
    library = Path("/usr/lib/x86_64-linux-gnu/libLLVM.so.19.1")
    if library.exists():
        environment.setdefault("DRJIT_LIBLLVM_PATH", str(library))
    return environment


def has_mitsuba(python):
    try:
        return subprocess.run([python, "-c", "import mitsuba, numpy"], capture_output=True, check=False).returncode == 0
    except OSError:
        return False


def commands_of(case, args, with_peer):
    """Name of the setting -> command."""
    commands = {}
    if with_peer:
        for guiding, spp in PEER_SETTINGS[case]:
            commands[f"peer {guiding} {spp}"] = [
                args.python, args.peer / "gradients.py", case, "--guiding", guiding, "--spp", spp,
                "--repeats", args.repeats]
    ours = [args.bench, "--meshes", args.peer / "scenes", "--case", case, "--repeats", args.repeats]
    if args.references:
        ours += ["--references", args.references]
    for form, spp, sppe, direct, indirect, pixel, guide in OUR_SETTINGS[case]:
        commands[f"ours {form} {guide} {spp}/{sppe}/{direct}/{indirect}/{pixel}"] = ours + [
            "--form", form, "--spp", spp, "--sppe", sppe, "--spp-direct", direct, "--spp-indirect", indirect,
            "--spp-pixel", pixel, "--guide", guide]
    commands["ours found 64"] = ours + ["--spp", "64"]  # budgets and form, as derivative images have them
    commands["ours differences 64"] = ours + ["--spp", "64", "--finite-differences", "0"]
    return {name: [str(part) for part in command] for name, command in commands.items()}


def summarise(rows):
    """One row for all rounds of a setting."""
    summary = dict(rows[-1])
    for key in ("primal_s", "gradient_s"):
        summary[key] = statistics.median(row[key] for row in rows)
    for key in ("variance", "mean_square_of_derivative"):
        summary[key] = statistics.fmean(row[key] for row in rows)
    summary["ratio"] = summary["gradient_s"] / summary["primal_s"]
    summary["efficiency"] = 1.0 / (summary["variance"] * summary["gradient_s"])
    return summary


def duel(case, args, with_peer):
    commands = commands_of(case, args, with_peer)
    rows = {name: [] for name in commands}
    for number in range(args.rounds):
        for name, command in commands.items():
            seed = [] if name.startswith("peer") else ["--seed", str(1000 * number)]
            rows[name] += run(command + seed, peer_environment())
    return {name: summarise(r) for name, r in rows.items()}


def reference_mean_square(results):
    return next((r["agreement"]["reference_mean_square"] for r in results.values() if "agreement" in r), None)


def judge(case, results):
    """Best unbiased efficiencies, their ratio and what is wanted."""
    wanted_setting, wanted = TARGETS[case]
    reference = reference_mean_square(results)

    def is_unbiased(row):
        if "agreement" in row:
            return row["agreement"]["z_rms"] < Z_RMS
        return reference is None or abs(row["mean_square_of_derivative"] / reference - 1.0) < BIAS

    def best(side):
        rows = {n: r for n, r in results.items() if n.startswith(side) and "differences" not in n and is_unbiased(r)}
        return max(rows, key=lambda n: rows[n]["efficiency"], default=None)

    ours = best("ours")
    peer = wanted_setting if wanted_setting in results else best("peer")
    verdict = {"ours": ours, "peer": peer, "wanted": wanted}
    if ours and peer:
        verdict["ratio"] = results[ours]["efficiency"] / results[peer]["efficiency"]
    if ours:
        verdict["over_differences"] = results[ours]["efficiency"] / results["ours differences 64"]["efficiency"]
    return verdict


def print_table(case, results, verdict):
    print(f"\n{case}")
    print(f"{'setting':42}{'primal s':>10}{'deriv. s':>10}{'ratio':>8}{'variance':>11}{'efficiency':>12}"
          f"{'mean sq.':>11}{'z rms':>8}{'z mean':>8}{'rel. L2':>9}{'noise':>8}")
    for name, r in results.items():
        a = r.get("agreement", {})
        figures = "".join(f"{a[key]:{width}.3f}" if key in a else " " * (width - 1) + "-"
                          for key, width in (("z_rms", 8), ("z_mean", 8), ("relative_l2", 9), ("noise_l2", 8)))
        print(f"{name:42}{r['primal_s']:10.3f}{r['gradient_s']:10.3f}{r['ratio']:8.1f}{r['variance']:11.3g}"
              f"{r['efficiency']:12.4g}{r['mean_square_of_derivative']:11.3g}{figures}")
    if "ratio" in verdict:
        print(f"  {verdict['ours']} is {verdict['ratio']:.3g} times as efficient as {verdict['peer']} "
              f"(wanted: {verdict['wanted']:g})")
    if "over_differences" in verdict:
        print(f"  and {verdict['over_differences']:.3g} times as efficient as central differences of our primal")


def parse_arguments():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--bench", type=Path, required=True)
    parser.add_argument("--peer", type=Path, required=True)
    parser.add_argument("--python", default=sys.executable)
    parser.add_argument("--references", type=Path)
    parser.add_argument("--cases", nargs="+", choices=CASES, default=CASES)
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--repeats", type=int, default=8)
    parser.add_argument("--out", type=Path)
    return parser.parse_args()


def main():
    args = parse_arguments()
    with_peer = has_mitsuba(args.python)
    if not with_peer:
        print(f"*** SKIPPED: the peer. {args.python} cannot import mitsuba and numpy; see tests/bench/README.md. ***",
              file=sys.stderr)
    if not args.references:
        print("*** NOT CHECKED: the means. --references is not given; see tests/bench/README.md. ***", file=sys.stderr)
    report = {}
    for case in args.cases:
        results = duel(case, args, with_peer)
        verdict = judge(case, results)
        print_table(case, results, verdict)
        sys.stdout.flush()
        report[case] = {"results": results, "verdict": verdict}
        if args.out:
            args.out.write_text(json.dumps(report, indent=1))


if __name__ == "__main__":
    main()
