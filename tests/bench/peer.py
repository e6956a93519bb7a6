#!/usr/bin/env python3
"""The same programs through `headstock simulate` and through LinuxCNC's trajectory planner, under the same limits (velocity
500 mm/s, acceleration 2,000 mm/s² on every axis, jerk not limited, tolerance 0.01 mm): who needs longer?

    tests/bench/peer.py [--bin build/release/bin/headstock] [--peer ../shared/tools/linuxcnc-peer] [--minutes 15] [--blend-rapids]
                        [--keep FOLDER] [FOLDER or PROGRAM…]

The wavy surface of the motion bench always, PROGRAMs besides, the shortest first. Both get the same moves, feeds and units
(G0-G3, G10, G20/G21, G54-G59, F), rounded to the control's least increment (0.001 mm, 0.0001 inch: more places make a very
short arc a full circle on one side only); tool, spindle, comment and end words are left out. Both cut in G64 with the same
tolerance. The control positions with an exact stop at either end of a G0, so LinuxCNC has G61.1 there; --blend-rapids
leaves it G64 throughout, which no control here may do. A program that takes longer than --minutes by our own prediction
is cut behind a block so that it does not; both sides run what is left.

LinuxCNC runs in real time, so this takes as long as the programs do, but little of a processor: as root it goes before other
processes, and its servo thread makes up for a late period. What starting a program costs is measured with lines of known
time in the same run (in LinuxCNC the least of three) and taken off, on both sides. Exit status 1 when Headstock needs longer
for one, or one has no result."""
import argparse
import json
import math
import os
import pathlib
import re
import subprocess
import sys
import tempfile
from decimal import ROUND_HALF_UP, Decimal

from judged_mill import ACCELERATION, TOLERANCE, VELOCITY, machine_file

options = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
options.add_argument("--bin", default="build/release/bin/headstock")
options.add_argument("--peer", default="../shared/tools/linuxcnc-peer")
options.add_argument("--minutes", type=float, default=15)
options.add_argument("--blend-rapids", action="store_true")
options.add_argument("--keep", type=pathlib.Path, help="write what both sides ran into this folder")
options.add_argument("programs", nargs="*", type=pathlib.Path)
given = options.parse_args()

# A line of 100 mm at 100 mm/s and the way back, with a stop at either end: 1.05 s each under the acceleration limit.
KNOWN_LINES, KNOWN_S = "G17 G21 G90 G94 G61\nG1 X100. F6000.\nX0.", 2 * (1 + 100 / ACCELERATION)

WORD = re.compile(r"([A-Z])\s*([-+]?(?:\d+\.?\d*|\.\d+))")
LEFT_OUT = {"N", "O", "T", "S", "M", "D", "H"}
LEFT_OUT_CODES = {17, 20, 21, 40, 43, 49, 54, 61, 64, 80, 90, 94}  # said at the top, or not about motion
LENGTHS = {"X", "Y", "Z", "I", "J", "K", "R"}


class Failed(Exception):
    pass


def surface():
    """20 passes of 400 segments of 0.1 mm on z = 2 sin(0.8 x) cos(0.5 y), there and back, F6000."""
    for row in range(20):
        for step in range(401):
            x, y = 0.1 * (400 - step if row % 2 else step), 0.5 * row
            yield f"G1 X{x:.4f} Y{y:.4f} Z{2 * math.sin(0.8 * x) * math.cos(0.5 * y):.5f} F6000."


def moves_of(file):
    """The words that mean the same to both, block by block; nothing else may be in the program."""
    increment = Decimal("0.001")
    for number, line in enumerate(file.read_text(errors="replace").splitlines(), 1):
        line = re.sub(r"\([^)]*\)|;.*|%", "", line).upper()
        words = WORD.findall(line)
        codes = {float(value) for letter, value in words if letter == "G"}
        if WORD.sub("", line).strip() or codes & {18, 19, 91}:
            raise Failed(f"line {number} is not in the subset both understand: {line.strip()[:40]}")
        if 20 in codes:
            increment = Decimal("0.0001")
            yield "G20"  # alone: in the same block F counts in the units before it in LinuxCNC
        block = []
        for letter, value in words:
            tolerance = letter == "P" and 64 in codes  # of LinuxCNC's G64
            if letter in LENGTHS:
                value = Decimal(value).quantize(increment, ROUND_HALF_UP)
            if letter not in LEFT_OUT and not (letter == "G" and float(value) in LEFT_OUT_CODES) and not tolerance:
                block.append(f"{letter}{value}")
        if block:
            yield " ".join(block)


def predicted(program, text):
    program.write_text(f"O1\n{text}\nM30\n")
    run = subprocess.run([given.bin, "simulate", "--profile", "fanuc-0i-m", "--machine", folder / "machine.toml",
                          "--params", folder / "parameters.json", "--set", "lenient=true", "--quick", program], capture_output=True, text=True)
    if run.returncode != 0:
        raise Failed(f"{run.stderr.strip()} {run.stdout.strip()[:200]}")
    return json.loads(run.stdout)["time_s"]


def exact_stops_at_rapids(blocks):
    """A block stops at its end when it positions or the next one does."""
    rapid = []
    for block in blocks:
        codes = re.findall(r"G0*([0123])\b", block)
        rapid.append(codes[-1] == "0" if codes else bool(rapid) and rapid[-1])
    stops, tolerance = False, TOLERANCE
    for block, here, following in zip(blocks, rapid, rapid[1:] + [False]):
        if block == "G20":
            tolerance = TOLERANCE / 25.4
        if (here or following) != stops:
            stops = not stops
            yield "G61.1" if stops else f"G64 P{tolerance:.6f}"
        yield block


def measured(program, blocks, limit_s):
    text = "\n".join(blocks if given.blend_rapids else exact_stops_at_rapids(blocks))
    program.write_text(f"G17 G21 G90 G94 G64 P{TOLERANCE}\n{text}\nM2\n")
    known = program.with_name("known-lines.ngc")
    known.write_text(f"{KNOWN_LINES}\nM2\n")
    before_others = ["nice", "-n", "-15"] if os.geteuid() == 0 else []
    run = subprocess.run([*before_others, given.peer, "--accel", str(ACCELERATION), "--vel", str(VELOCITY),
                          "--max", str(math.ceil(limit_s)), known, known, known, program], capture_output=True, text=True)
    results = [json.loads(line) for line in run.stdout.splitlines() if line.startswith("{")]
    if run.returncode != 0 or len(results) != 4:
        raise Failed(f"LinuxCNC did not run: {run.stderr.strip()[-200:]}")
    for result in results:
        if result.get("error"):
            raise Failed(f"LinuxCNC stopped in {result['program']} after {result['time_s']} s: {result['error']}")
    *starts, time_s = (result["time_s"] for result in results)
    return time_s - (min(starts) - KNOWN_S)


def cut(program, moves):
    """As many blocks as take at most --minutes. @return them, and our time for them"""
    def time_of(blocks):
        return predicted(program, "\n".join(["G17 G21 G90 G94 G64", *blocks])) - start_s

    time_s = time_of(moves)
    if time_s <= 60 * given.minutes:
        return moves, time_s
    enough, too_many = 0, len(moves)
    while too_many - enough > 1:
        middle = (enough + too_many) // 2
        time_s = time_of(moves[:middle])
        enough, too_many = (middle, too_many) if time_s <= 60 * given.minutes else (enough, middle)
    return moves[:enough], time_of(moves[:enough])


programs = []
for path in given.programs:
    programs += sorted(p for p in path.rglob("*") if p.suffix in (".nc", ".ngc", ".gcode")) if path.is_dir() else [path]

bad = 0
with tempfile.TemporaryDirectory() as temporary:
    folder = given.keep or pathlib.Path(temporary)
    folder.mkdir(exist_ok=True)
    (folder / "machine.toml").write_text(machine_file("peer", 1e12))
    (folder / "parameters.json").write_text('{"1401#1": 1}')  # G0 on a straight line, as LinuxCNC's
    start_s = predicted(folder / "known-lines.nc", KNOWN_LINES) - KNOWN_S
    runs = []
    for name, moves in [("surf", surface())] + [(file.stem, moves_of(file)) for file in programs]:
        try:
            moves = list(moves)
            blocks, our_s = cut(folder / f"{name}.nc", moves)
            runs.append((our_s, name, blocks, len(moves)))
        except Failed as reason:
            bad += 1
            print(f"{name:24} no result: {reason}", flush=True)
    for our_s, name, blocks, whole in sorted(runs):
        try:
            their_s = measured(folder / f"{name}.ngc", blocks, 3 * our_s + 60)
            bad += our_s >= their_s
            what = f"   the first {len(blocks)} of {whole} blocks" if len(blocks) < whole else ""
            print(f"{name:24} headstock {our_s:8.2f} s   LinuxCNC {their_s:8.2f} s   ratio {our_s / their_s:.3f}{what}", flush=True)
        except Failed as reason:
            bad += 1
            print(f"{name:24} no result: {reason}", flush=True)
sys.exit(1 if bad else 0)
