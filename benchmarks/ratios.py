"""Run the benchmarks once, in one process, and print them as ratios."""

import os
import resource
import sys
import time
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))
import before
import files
from benchmarks.speed import (
    Ewm,
    FemTemperature,
    Fit,
    Loop,
    LoopOfEight,
    YearAtOneSecond,
)


def best(work, *arguments, repeat=5):
    """Shortest of some runs. [s]"""
    times = []
    for _ in range(repeat):
        start = time.perf_counter()
        work(*arguments)
        times.append(time.perf_counter() - start)
    return min(times)


def line(work, value, reach):
    print(f"{work:<58}{value:>14}   {reach}")


def main():
    print(f"{os.cpu_count()} cores, best of 5 runs; against prilliman one run each")
    line("work", "measured", "reach")
    for steps in Ewm.params:
        bench = Ewm()
        bench.setup(steps)
        ours = best(bench.time_ewm, steps)
        filtered = best(bench.time_lfilter, steps)
        timed = best(bench.time_pandas_times, steps)
        name = f"ewm, 10 M rows, {steps} steps"
        line(f"{name}, against scipy lfilter", f"{ours / filtered:.2f} x", "<= 3 x")
        line(f"{name}, against pandas times", f"1/{timed / ours:.1f}", "<= 1/5")
    for record, reach in zip(FemTemperature.params, ("<= 1/5", "<= 1/1000")):
        bench = FemTemperature()
        bench.setup(record)
        # a study runs either once; a short record first pays for the imports
        whole, short = bench.drivers, tuple(c.iloc[:999] for c in bench.drivers)
        for bench.drivers in (short, whole):
            ours = best(bench.time_fem_temperature, record, repeat=1)
            theirs = best(bench.time_prilliman, record, repeat=1)
        line(
            f"fem_temperature, {record}, against prilliman",
            f"1/{theirs / ours:,.0f}",
            reach,
        )
    for dynamics in Fit.params:
        bench = Fit()
        bench.setup(dynamics)
        seconds = best(bench.time_fit_fem, dynamics)
        line(f"fit_fem, year at 1 min, {dynamics}", f"{seconds:.2f} s", "<= 1 s")
    for row in (*before.lines(), *files.lines()):
        line(*row)
    seconds = {}
    for years in Loop.params:
        bench = Loop()
        bench.setup(years)
        seconds[years] = best(bench.time_close_loop, years, repeat=2)
        if years == 1:
            line("close_loop, year at 1 min", f"{seconds[1]:.1f} s", "<= 6 s")
            if sys.platform == "linux":
                peak = peak_memory(bench.time_close_loop, years) / 2**30
                line("its process at the peak", f"{peak:.2f} GiB", "<= 2 GiB")
        else:
            ratio = seconds[years] / seconds[1]
            line(f"close_loop, {years} years, against one", f"{ratio:.1f} x", "linear")
    bench = LoopOfEight()
    bench.setup(1)
    eight = best(bench.time_close_loop, 1, repeat=2)
    line("close_loop, year at 1 min, eight effects", f"{eight:.1f} s", "<= 6 s")
    bench = YearAtOneSecond()
    bench.setup()
    seconds = best(bench.time_fem_temperature, repeat=3)
    line("fem_temperature, year at 1 s", f"{seconds:.2f} s", "<= 4 s")
    if sys.platform == "linux":
        line(
            "its memory, against that of the input",
            f"{memory_ratio(bench):.1f} x",
            "<= 4 x",
        )


def memory_ratio(bench):
    """Memory that the work adds at its peak, over that of its input."""
    columns = sum(series.to_numpy().nbytes for series in bench.drivers)
    held = columns + bench.drivers[0].index.nbytes
    pages = int(Path("/proc/self/statm").read_text().split()[1])
    added = peak_memory(bench.time_fem_temperature) - pages * resource.getpagesize()
    return added / held


def peak_memory(work, *arguments):
    """High-water mark of a copy of this process that does the work. [byte]"""
    reader, writer = os.pipe()
    child = os.fork()
    if child == 0:  # its own high-water mark, which starts where the input is
        Path("/proc/self/clear_refs").write_text("5")
        work(*arguments)
        os.write(writer, repr(before.peak()).encode())
        os._exit(0)
    os.waitpid(child, 0)
    return float(os.read(reader, 100)) * 2**30


if __name__ == "__main__":
    main()
