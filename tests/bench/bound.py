#!/usr/bin/env python3
"""Every part program of a folder: the time `headstock simulate` takes against the least time along the same path, under the
same limits (velocity 500 mm/s, acceleration 2,000 mm/s² on every axis, jerk not limited, the program's feeds).

    tests/bench/bound.py [--bin build/release/bin] [--period-us 1000] [--path-us 250] [--lines 0] [FOLDER or PROGRAM…]
                                                                                                default ../shared/corpus

The commanded samples are the path; bench_bound (target bench, least_time.hpp) finds the fastest run along it and is first
checked itself against lines, circles and corners. The time is that of a run at --period-us, the path that of a run at
--path-us: the path does not depend on the period, but samples 1 ms apart cut its sharpest corners (bear.nc: a bound 0.5 %
lower, at 0.25 ms less than 0.1 % below the one of the spline itself). Times are those in which the axes move, with pauses up to 50 ms
(exact stops); dwells, M codes and tool changes count on neither side. --lines N names the lines that lose most of the
run at --path-us [ms]. Smallest program first; exit status 1 when one takes more than 1.03 times its bound."""
import argparse
import json
import os
import pathlib
import subprocess
import sys
import tempfile

from judged_mill import machine_file

MOST = 1.03

options = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
options.add_argument("--bin", default="build/release/bin", type=pathlib.Path)
options.add_argument("--period-us", type=int, default=1000)
options.add_argument("--path-us", type=int, default=250)
options.add_argument("--lines", type=int, default=0)
options.add_argument("programs", nargs="*", default=["../shared/corpus"])
given = options.parse_args()
programs = []
for name in given.programs:
    path = pathlib.Path(name)
    programs += [p for p in path.rglob("*") if p.suffix in (".nc", ".ngc", ".gcode")] if path.is_dir() else [path]
if not programs:
    sys.exit(f"bound: no programs in {', '.join(given.programs)}: nothing was measured")

subprocess.run([given.bin / "bench_bound", "--check"], check=True)


def measured(program, machine, period_us):
    """@return what bench_bound says of a run at this period; or why it says nothing"""
    # Samples go from one to the other while both run: a trace is up to gigabytes.
    reads, writes = os.pipe()
    with subprocess.Popen([given.bin / "headstock", "simulate", "--profile", "fanuc-0i-m", "--machine", machine, "--set",
                           "lenient=true", "--quick", "--period-us", str(period_us),
                           "--trace", f"/dev/fd/{writes}", program], pass_fds=[writes], stdout=subprocess.PIPE,
                          stderr=subprocess.STDOUT, text=True) as run:
        os.close(writes)
        judge = subprocess.run([given.bin / "bench_bound", program, "/dev/stdin", str(given.lines)], stdin=reads,
                               capture_output=True, text=True)
        os.close(reads)
        said = run.stdout.read()
    if run.returncode != 0 or judge.returncode != 0:
        return None, f"{judge.stderr.strip()[:120]} {said.strip()[:120]}"
    return json.loads(judge.stdout), ""


slow = 0
with tempfile.TemporaryDirectory() as folder:
    machine = pathlib.Path(folder, "machine.toml")
    machine.write_text(machine_file("bound", 1e12))
    for program in sorted(programs, key=lambda p: p.stat().st_size):
        ours, wrong = measured(program, machine, given.period_us)
        path, wrong = measured(program, machine, given.path_us) if ours and given.path_us != given.period_us else (ours, wrong)
        if not path:
            slow += 1
            print(f"{program.name:24} no result: {wrong}", flush=True)
            continue
        ratio = ours["ours_s"] / path["bound_s"]
        slow += ratio > MOST
        print(f"{program.name:24} {ours['ours_s']:10.3f} s   bound {path['bound_s']:10.3f} s   ratio {ratio:.4f}"
              f"{'  SLOW' if ratio > MOST else ''}", flush=True)
        if given.lines:
            print("    " + ", ".join(f"line {line}: {ms} ms" for line, ms in path["lost_ms"].items()))
sys.exit(1 if slow else 0)
