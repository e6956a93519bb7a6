#!/usr/bin/env python3
"""Runs the integration tests and closes with "N passed, N failed".

    tests/integration/run.py [--bin build/release/bin] [--keep] [NAME…]     NAME: part of a test's id, e.g. drip
"""
import argparse
import os
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


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--bin", default=os.path.join(HERE, "../../build/release/bin"))
    parser.add_argument("--keep", action="store_true", help="keep the data folders of the tests")
    parser.add_argument("names", nargs="*")
    options = parser.parse_args()
    os.environ["HEADSTOCK_BIN"] = os.path.abspath(options.bin)
    if options.keep:
        os.environ["HEADSTOCK_KEEP"] = "1"
    sys.path.insert(0, HERE)
    found = unittest.defaultTestLoader.discover(HERE, pattern="test_*.py")
    suite = unittest.TestSuite(chosen(found, options.names))
    result = unittest.TextTestRunner(stream=sys.stdout, resultclass=Counting, verbosity=0).run(suite)
    # A test with three bad sub-tests is one failed test.
    failed = len({(getattr(t, "test_case", t)).id() for t, _ in result.failures + result.errors})
    print(f"{result.testsRun - failed} passed, {failed} failed")
    return 1 if failed or not result.testsRun else 0


if __name__ == "__main__":
    sys.exit(main())
