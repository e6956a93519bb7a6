"""The small edition of count_parts.py, on every commit."""
import unittest

import count_parts


class Counts(unittest.TestCase):
    def test_parts_on_three_machines_with_fifteen_kills_and_cuts(self):
        figures = count_parts.run(agents=3, parts=36, trouble=15, seed=4, say=lambda text: None)
        self.assertEqual(figures["parts"], 36)
        self.assertGreaterEqual(figures["runs"], 36)


if __name__ == "__main__":
    unittest.main()
