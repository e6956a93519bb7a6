#!/usr/bin/env python3
"""Every part program of a folder through `headstock check` in lenient mode: no false alarm.

    tests/conformance/corpus.py [--bin build/release/bin/headstock] [FOLDER]      default ../shared/corpus

A program fits a profile when the control has every G code in it and its G90 is absolute positioning (lathes: G-code
system B); then it must be clean. Of one that does not fit the codes are named. Exit status 1 after a false alarm, or
when nothing was checked."""
import argparse
import pathlib
import re
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parents[2]
# Profile, G-code system, column of its gcodes.tsv. The other lathes have two axes and no absolute G90.
PROFILES = [("fanuc-0i-m", "A", 0), ("fanuc-0i-t", "B", 1), ("k2000tc", "B", 1)]
AXIS = """[axis.{}]
designation = "radius"
rapid_mm_min = 30000
max_feed_mm_min = 30000
max_acceleration_mm_s2 = 2000
max_jerk_mm_s3 = 50000
min_mm = -5000
max_mm = 5000
"""


def tenths(code):
    whole, _, part = code.partition(".")
    return int(whole) * 10 + int(part or 0)


def codes_of_control(profile, column):
    """Numbers of its G codes, in tenths."""
    rows = (ROOT / "controller-agent/dialects" / profile / "gcodes.tsv").read_text(encoding="utf-8").splitlines()
    names = [name for row in rows[1:] if row and not row.startswith("#") for name in row.split("\t")[column].split("|")]
    return {tenths(name[1:]) for name in names if re.fullmatch(r"G\d+(\.\d)?", name)}


def codes_of_program(text):
    plain = re.sub(r"\([^)]*\)|;.*", "", text)
    return {tenths(code) for code in re.findall(r"[Gg]\s*(\d+(?:\.\d)?)", plain)}


def name_of(code):
    return f"G{code // 10:02d}" + (f".{code % 10}" if code % 10 else "")


def main():
    options = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    options.add_argument("--bin", default=str(ROOT / "build/release/bin/headstock"))
    options.add_argument("folder", nargs="?", default=str(ROOT.parent / "shared/corpus"))
    given = options.parse_args()
    programs = sorted(p for p in pathlib.Path(given.folder).rglob("*") if p.suffix in (".nc", ".ngc", ".gcode"))
    checked = false_alarms = 0
    with tempfile.TemporaryDirectory() as folder:
        for profile, system, column in PROFILES:
            machine = pathlib.Path(folder, profile + ".toml")
            machine.write_text(f'[machine]\nname = "corpus"\nprofile = "{profile}"\n' + "".join(map(AXIS.format, "XYZ")))
            known = codes_of_control(profile, column)
            for program in programs:
                foreign = sorted(codes_of_program(program.read_text(errors="replace")) - known)
                run = subprocess.run([given.bin, "check", "--profile", profile, "--machine", str(machine), "--set",
                                      "lenient=true", f"gcode_system={system}", str(program)],
                                     capture_output=True, text=True)
                said = (run.stdout + run.stderr).strip().splitlines()
                if foreign:  # it must say so, not read on past the code
                    verdict = "does not fit: " + " ".join(map(name_of, foreign))
                    wrong = run.returncode != 2
                else:
                    checked += 1
                    verdict = "clean" if run.returncode == 0 and not said else " / ".join(said[:2])
                    wrong = verdict != "clean"
                false_alarms += wrong
                print(f"{profile:12} {program.name:26} {verdict}{'  WRONG' if wrong else ''}", flush=True)
    print(f"{checked} programs checked, {false_alarms} wrong")
    return 1 if false_alarms or not checked else 0


if __name__ == "__main__":
    sys.exit(main())
