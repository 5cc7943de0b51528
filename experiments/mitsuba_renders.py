"""Mitsuba 3 in a process of its own, one per variant: a variant whose LLVM library is missing or unfit must not end the measurement.

The process may use one thread. CPU-seconds are user and system time of the whole process during the render call alone.
"""
import ctypes.util
import glob
import multiprocessing
import os
import re
import resource
from concurrent.futures import ProcessPoolExecutor

import numpy as np

LIBRARIES = ["/usr/lib/*/libLLVM*.so*", "/usr/lib64/libLLVM*.so*", "/usr/lib/llvm-*/lib/libLLVM*.so*", "/opt/homebrew/opt/llvm/lib/libLLVM*"]
NAME = re.compile(r"libLLVM[-.](?:so\.)?(\d+)(?:\.so|\.\d+|$)")  # libLLVM-18.so, libLLVM.so.19.1


def newest_llvm():
    """The newest LLVM library found, or None. Dr.Jit rejects old ones, and some crash on new processors."""
    found = [(int(m[1]), path) for pattern in LIBRARIES for path in glob.glob(pattern) if (m := NAME.search(os.path.basename(path)))]
    return max(found)[1] if found else ctypes.util.find_library("LLVM")


def processor_seconds():
    usage = resource.getrusage(resource.RUSAGE_SELF)
    return usage.ru_utime + usage.ru_stime


def _start(variant, home):
    """In the new process. Kernels are cached in the home folder: with an empty one the first render call compiles them."""
    os.environ["HOME"] = str(home)
    if variant.startswith("llvm") and (library := newest_llvm()):
        os.environ.setdefault("DRJIT_LIBLLVM_PATH", library)
    import drjit
    import mitsuba

    mitsuba.set_variant(variant)
    drjit.set_thread_count(1)


_scenes = {}


def _render(scene_file, spp, seed):
    import mitsuba

    if scene_file not in _scenes:
        _scenes[scene_file] = mitsuba.load_file(str(scene_file))
    before = processor_seconds()
    image = np.array(mitsuba.render(_scenes[scene_file], spp=spp, seed=seed))
    return image.astype(np.float64), processor_seconds() - before


class Mitsuba:
    """One variant. Calls raise BrokenProcessPool where it cannot run."""

    def __init__(self, variant, home):
        spawn = multiprocessing.get_context("spawn")
        self.pool = ProcessPoolExecutor(1, mp_context=spawn, initializer=_start, initargs=(variant, home))

    def render(self, scene_file, spp, seed):
        """The image, linear RGB, and the CPU-seconds. The integrator is the scene's."""
        return self.pool.submit(_render, scene_file, spp, seed).result()

    def close(self):
        self.pool.shutdown()
