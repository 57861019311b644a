#!/usr/bin/env python3
"""What `check` says of the time and what the remaining time says on the way, beside what fits take.

forecasts.py --pathfit BUILD/app/pathfit CONFIG ... [--threads N] [--set KEY=VALUE ...] [--runs FOLDER] [--out FILE.json]

Per stage: seconds said before and taken. Per fit: those of all stages, and the remaining time after the second round of the
run and of each stage over what was still to come then. A machine with other work to do takes longer than it said.
"""
import argparse
import json
import re
import subprocess
import sys
import tempfile
import time
from pathlib import Path

ROUND = re.compile(r"stage=(\S+) it=(\d+)/\d+ .*eta_s=([0-9.]+)")
END = re.compile(r"stage=(\S+) end=true")


def said(program, config, page, options):
    out = subprocess.run([program, "check", str(config), "--json", "-o", str(page), *options], capture_output=True, text=True)
    if out.returncode != 0:
        sys.exit(f"{config}: check ended with status {out.returncode}:\n{out.stderr}")
    return json.loads(out.stdout)["stages"]


def fit(program, config, run, options):
    """Times of rounds and ends of stages, seconds from the start: [stage, round or None, seconds, remaining]."""
    events = []
    began = time.monotonic()
    process = subprocess.Popen([program, "fit", str(config), "-o", str(run), *options], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
    for line in process.stdout:
        seconds = time.monotonic() - began
        if match := ROUND.search(line):
            events.append([match[1], int(match[2]), seconds, float(match[3])])
        elif match := END.search(line):
            events.append([match[1], None, seconds, 0.0])
    if process.wait() != 0:
        sys.exit(f"{config}: fit ended with status {process.returncode}; see {run}")
    return events


def compare(stages, events):
    """The start is the first stage's."""
    result = {"stages": {}, "remaining": {}}
    before = 0.0
    end = max(seconds for _, _, seconds, _ in events)
    for stage in stages:
        name = stage["name"]
        taken = max((seconds for s, _, seconds, _ in events if s == name), default=before) - before
        result["stages"][name] = {"said": stage["likely_s"], "taken": taken, "most": stage["most_s"]}
        before += taken
        rounds = [e for e in events if e[0] == name and e[1] is not None]
        if len(rounds) > 1:
            result["remaining"][name] = rounds[1][3] / max(1e-9, end - rounds[1][2])
    total_said = sum(s["said"] for s in result["stages"].values())
    result.update(said=total_said, taken=end, ratio=total_said / end)
    return result


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--pathfit", required=True)
    parser.add_argument("configs", nargs="+", type=Path)
    parser.add_argument("--threads", type=int)
    parser.add_argument("--set", action="append", default=[])
    parser.add_argument("--runs", type=Path)
    parser.add_argument("--out", type=Path)
    args = parser.parse_args()
    runs = args.runs or Path(tempfile.mkdtemp(prefix="forecasts_"))
    runs.mkdir(parents=True, exist_ok=True)
    options = [f"--set={value}" for value in args.set] + ([f"--threads={args.threads}"] if args.threads else [])
    results = {}
    for i, config in enumerate(args.configs):
        run = runs / f"{i:02d}_{config.stem}"
        stages = said(args.pathfit, config, f"{run}_check.html", options)
        result = compare(stages, fit(args.pathfit, config, run, options))
        results[str(config)] = result
        for name, stage in result["stages"].items():
            print(f"{config.stem:20} {name:12} said {stage['said']:7.1f} s, took {stage['taken']:7.1f} s: {stage['said'] / max(1e-9, stage['taken']):.2f}")
        remaining = ", ".join(f"{name} {ratio:.2f}" for name, ratio in result["remaining"].items())
        print(f"{config.stem:20} {'all':12} said {result['said']:7.1f} s, took {result['taken']:7.1f} s: {result['ratio']:.2f}; "
              f"remaining time after second rounds over what came: {remaining}", flush=True)
    if args.out:
        args.out.write_text(json.dumps(results, indent=1))


if __name__ == "__main__":
    main()
