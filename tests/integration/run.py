#!/usr/bin/env python3
"""Runs the integration tests and closes with "N passed, N failed".

    tests/integration/run.py [--bin build/release/bin] [--keep] [--jobs N] [NAME…]     NAME: part of a test's id, e.g. drip

Files of tests run side by side, two at a time unless told: they wait for processes most of the time.
"""
import argparse
import concurrent.futures
import os
import re
import subprocess
import sys
import time
import unittest

HERE = os.path.dirname(os.path.abspath(__file__))


class Counting(unittest.TextTestResult):
    """One line a test, with the time it took: a slow test should be seen."""

    def startTest(self, test):
        self.began = time.monotonic()
        super().startTest(test)

    def line(self, word, test):
        self.stream.writeln(f"{word:6} {time.monotonic() - self.began:6.1f} s  {test.id()}")
        self.stream.flush()

    def addSuccess(self, test):
        unittest.TestResult.addSuccess(self, test)
        self.line("ok", test)

    def addFailure(self, test, err):
        unittest.TestResult.addFailure(self, test, err)
        self.line("FAIL", test)

    def addError(self, test, err):
        unittest.TestResult.addError(self, test, err)
        self.line("ERROR", test)

    def getDescription(self, test):
        return test.id()


def chosen(suite, names):
    for item in suite:
        if isinstance(item, unittest.TestSuite):
            yield from chosen(item, names)
        elif not names or any(name in item.id() for name in names):
            yield item


def side_by_side(modules, jobs, arguments):
    """Each file of tests in a process of its own. @return passed, failed"""
    def run(module):
        command = [sys.executable, os.path.abspath(__file__), "--jobs", "1", *arguments, module + "."]
        return subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)

    passed = failed = 0
    with concurrent.futures.ThreadPoolExecutor(jobs) as pool:
        for one in concurrent.futures.as_completed([pool.submit(run, module) for module in modules]):
            print(one.result().stdout, flush=True)
            counts = re.findall(r"^(\d+) passed, (\d+) failed$", one.result().stdout, re.M)
            good, bad = map(int, counts[-1]) if counts else (0, 1)   # it broke down
            passed, failed = passed + good, failed + bad
    return passed, failed


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--bin", default=os.path.join(HERE, "../../build/release/bin"))
    parser.add_argument("--keep", action="store_true", help="keep the data folders of the tests")
    parser.add_argument("--jobs", type=int, default=2, help="files of tests at a time")
    parser.add_argument("names", nargs="*")
    options = parser.parse_args()
    os.environ["HEADSTOCK_BIN"] = os.path.abspath(options.bin)
    if options.keep:
        os.environ["HEADSTOCK_KEEP"] = "1"
    sys.path.insert(0, HERE)
    found = unittest.defaultTestLoader.discover(HERE, pattern="test_*.py")
    tests = list(chosen(found, options.names))
    modules = sorted({test.id().split(".")[0] for test in tests})
    if options.jobs > 1 and len(modules) > 1 and not options.names:
        passed, failed = side_by_side(modules, options.jobs, [f"--bin={options.bin}"] + ["--keep"] * options.keep)
        print(f"{passed} passed, {failed} failed")
        return 1 if failed or not passed else 0
    suite = unittest.TestSuite(tests)
    result = unittest.TextTestRunner(stream=sys.stdout, resultclass=Counting, verbosity=0).run(suite)
    # A test with three bad sub-tests is one failed test.
    failed = len({(getattr(t, "test_case", t)).id() for t, _ in result.failures + result.errors})
    print(f"{result.testsRun - failed} passed, {failed} failed")
    return 1 if failed or not result.testsRun else 0


if __name__ == "__main__":
    sys.exit(main())
