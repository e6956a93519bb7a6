#!/usr/bin/env python3
"""Every part program of a folder through `headstock simulate`, judged against the machine's limits: velocity 0.1 %,
acceleration 1 %, jerk 5 %, path inside the tolerance.

    tests/bench/corpus.py [--bin build/release/bin/headstock] [--jerk 50000] [FOLDER]      default ../shared/corpus

One line a program: time, realtime factor, worst share of each limit. Exit status 1 when one is outside."""
import argparse
import json
import pathlib
import subprocess
import sys
import tempfile

from judged_mill import ACCELERATION, TOLERANCE, VELOCITY, machine_file

options = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
options.add_argument("--bin", default="build/release/bin/headstock")
options.add_argument("--jerk", type=float, default=50000.0, help="mm/s³")
options.add_argument("folder", nargs="?", default="../shared/corpus")
given = options.parse_args()
programs = sorted(p for p in pathlib.Path(given.folder).rglob("*") if p.suffix in (".nc", ".ngc", ".gcode"))
if not programs:
    sys.exit(f"corpus: no programs in {given.folder}: nothing was measured")

machine = machine_file("corpus", given.jerk)

outside = 0
with tempfile.TemporaryDirectory() as folder:
    file = pathlib.Path(folder, "machine.toml")
    file.write_text(machine)
    for program in programs:
        run = subprocess.run([given.bin, "simulate", "--profile", "fanuc-0i-m", "--machine", str(file), "--set",
                              "lenient=true", str(program)], capture_output=True, text=True)
        try:
            result = json.loads(run.stdout)
        except json.JSONDecodeError:
            outside += 1
            print(f"{program.name:24} no result: {run.stderr.strip()[:120]}")
            continue
        axes = result["axes"].values()
        shares = [max(axis[key] for axis in axes) / limit
                  for key, limit in (("max_v", VELOCITY), ("max_a", ACCELERATION), ("max_j", given.jerk))]
        error = result["max_path_error_mm"]
        bad = shares[0] > 1.001 or shares[1] > 1.01 or shares[2] > 1.05 or error > TOLERANCE
        outside += bad
        print(f"{program.name:24} {result['time_s']:9.2f} s {result['realtime_factor']:6.0f}x  "
              f"v {shares[0]:.3f} a {shares[1]:.3f} j {shares[2]:.3f} path {error:.4f} mm  "
              f"{result['end']} {len(result['alarms'])} alarms{'  OUTSIDE' if bad else ''}", flush=True)
sys.exit(1 if outside else 0)
