"""Runs the tests of the add-on, with a Python that has Blender as a module.

PHOTOTAXIS=path/of/phototaxis python run.py [NAME …]
"""

from __future__ import annotations

import os
import sys
import unittest
from pathlib import Path

HERE = Path(__file__).resolve().parent
sys.path[:0] = [str(HERE), str(HERE.parent)]
sys.dont_write_bytecode = True


def main() -> int:
    import phototaxis

    phototaxis.register()
    loader = unittest.TestLoader()
    names = sys.argv[1:]
    suite = loader.loadTestsFromNames(names) if names else loader.discover(str(HERE))
    result = unittest.TextTestRunner(verbosity=2).run(suite)
    phototaxis.unregister()
    return 0 if result.wasSuccessful() and result.testsRun else 1


if __name__ == "__main__":
    code = main()
    sys.stdout.flush()
    sys.stderr.flush()
    # Blender as a module does not always come down in one piece with what was registered.
    os._exit(code)
