#!/usr/bin/env python3
"""Every part program of a folder: the time `headstock simulate` takes against the least time along the same path, under the
same limits (velocity 500 mm/s, acceleration 2,000 mm/s² on every axis, jerk not limited, the program's feeds).

    tests/bench/bound.py [--bin build/release/bin] [--period-us 1000] [--lines 0] [FOLDER or PROGRAM…]   default ../shared/corpus

The commanded samples are the path; bench_bound (target bench, least_time.hpp) finds the fastest run along it and is first
checked itself against lines and circles. Times are those in which the axes move, with pauses up to 50 ms (exact stops);
dwells, M codes and tool changes count on neither side. --lines N names the lines that lose most [ms]. A finer period
tells how much of the difference is the period, and by how much the bound itself depends on the samples. Smallest
program first; exit status 1 when one takes more than 1.03 times its bound."""
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

slow = 0
with tempfile.TemporaryDirectory() as folder:
    machine = pathlib.Path(folder, "machine.toml")
    machine.write_text(machine_file("bound", 1e12))
    for program in sorted(programs, key=lambda p: p.stat().st_size):
        # Samples go from one to the other while both run: a trace is up to a gigabyte.
        reads, writes = os.pipe()
        with subprocess.Popen([given.bin / "headstock", "simulate", "--profile", "fanuc-0i-m", "--machine", machine, "--set",
                               "lenient=true", "--quick", "--period-us", str(given.period_us),
                               "--trace", f"/dev/fd/{writes}", program], pass_fds=[writes], stdout=subprocess.PIPE,
                              stderr=subprocess.STDOUT, text=True) as run:
            os.close(writes)
            judge = subprocess.run([given.bin / "bench_bound", program, "/dev/stdin", str(given.lines)], stdin=reads,
                                   capture_output=True, text=True)
            os.close(reads)
            said = run.stdout.read()
        if run.returncode != 0 or judge.returncode != 0:
            slow += 1
            print(f"{program.name:24} no result: {judge.stderr.strip()[:120]} {said.strip()[:120]}", flush=True)
            continue
        result = json.loads(judge.stdout)
        ratio = result["ours_s"] / result["bound_s"]
        slow += ratio > MOST
        print(f"{program.name:24} {result['ours_s']:10.3f} s   bound {result['bound_s']:10.3f} s   ratio {ratio:.4f}"
              f"{'  SLOW' if ratio > MOST else ''}", flush=True)
        if given.lines:
            print("    " + ", ".join(f"line {line}: {ms} ms" for line, ms in result["lost_ms"].items()))
sys.exit(1 if slow else 0)
