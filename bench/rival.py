"""Mitsuba 3 as the other renderer: finding it, running it, timing it."""

import os
import pathlib
import sys
import tempfile
import time

import mitsuba_scene

VERSION = "3.9.1"
ROOT = pathlib.Path(__file__).resolve().parent.parent
BENCH_DIR = pathlib.Path(os.environ.get("ETENDUE_BENCH_DIR", ROOT / "target" / "bench"))
LLVM_NAMES = ("libLLVM-19.so", "libLLVM.so.19.1")
LLVM_FOLDERS = (
    "/usr/lib/x86_64-linux-gnu",
    "/usr/lib/aarch64-linux-gnu",
    "/usr/lib/llvm-19/lib",
    "/usr/lib64",
    "/usr/lib",
)

INSTALL = f"""Mitsuba {VERSION} is not there. To install it (Python 3.11 or later, beside nothing else):
    python3 -m venv {BENCH_DIR}/mitsuba
    {BENCH_DIR}/mitsuba/bin/python -m pip install mitsuba=={VERSION} numpy
ETENDUE_BENCH_DIR names another directory than {BENCH_DIR}."""

INSTALL_LLVM = """Mitsuba's llvm variants need LLVM 19 (older ones fail to load or abort):
    apt-get install libllvm19
or set DRJIT_LIBLLVM_PATH to a libLLVM-19.so."""


def enter():
    """Continue this program in Mitsuba's virtual environment; ends with instructions if there is none."""
    home = BENCH_DIR / "mitsuba"
    if pathlib.Path(sys.prefix).resolve() == home.resolve():
        return
    python = home / "bin" / "python"
    if not python.exists():
        sys.exit(INSTALL)
    sys.stdout.flush()
    os.execv(python, [str(python), *sys.argv])


def load(variant, threads):
    """The `mitsuba` module, set up."""
    if variant.startswith("llvm") and "DRJIT_LIBLLVM_PATH" not in os.environ:
        found = [p for f in LLVM_FOLDERS for n in LLVM_NAMES if (p := pathlib.Path(f) / n).exists()]
        if not found:
            sys.exit(INSTALL_LLVM)
        os.environ["DRJIT_LIBLLVM_PATH"] = str(found[0])
    try:
        import mitsuba as mi
    except ImportError:
        sys.exit(INSTALL)
    if mi.__version__ != VERSION:
        sys.exit(f"Mitsuba {VERSION} is wanted, this is {mi.__version__}.\n{INSTALL}")
    mi.set_variant(variant)
    import drjit as dr

    # With one thread its pool has been seen to hang: to compare single threads, pin two to one core.
    dr.set_thread_count(max(2, threads))
    mi.set_log_level(mi.LogLevel.Warn)
    return mi


def fresh_kernel_cache():
    """Compiled kernels are kept in the home directory: an empty one makes the first render's time mean something."""
    home = tempfile.TemporaryDirectory(prefix="etendue-bench-")
    os.environ["HOME"] = home.name
    return home


class Renderer:
    """One scene in Mitsuba, rendered any number of times."""

    def __init__(self, mi, path, size, max_depth):
        self.mi = mi
        path = pathlib.Path(path)
        start = time.perf_counter()
        with tempfile.TemporaryDirectory(prefix="etendue-bench-") as scratch:
            source = mitsuba_scene.read(path)
            self.scene = mi.load_dict(mitsuba_scene.convert(mi, source, scratch, path.parent, size, max_depth))
        self.load_seconds = time.perf_counter() - start

    def render(self, spp, seed):
        """The image, float32 of shape (height, width, 3), and the seconds it took."""
        import drjit as dr
        import numpy as np

        start = time.perf_counter()
        image = self.mi.render(self.scene, spp=spp, seed=seed)
        dr.eval(image)
        dr.sync_thread()
        seconds = time.perf_counter() - start
        return np.array(image), seconds
