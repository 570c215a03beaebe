"""usage: count.py ELF FUNCTION [--target FUNCTION] [--core CORE] [-n CALLS] [--warm CALLS]

Calls setup() and then FUNCTION(0), FUNCTION(1), ... of an image. Counts the calls after the warm-up:
instructions exactly, cycles as modelled for a Cortex-M4F (m4.py). In the end bench_check() must
return 0 where the image has it.
"""
import argparse
import json

import places
from emulator import STACK_TOP, Image, Machine
from m4 import cycles_of

LINE = 16  # bytes of flash that a common accelerator holds in a line


def spread(values):
    return {"min": min(values), "avg": round(sum(values) / len(values), 1), "max": max(values)}


def start(image, core="m4f"):
    """A machine after setup()."""
    machine = Machine(image, core)
    if "setup" in image.symbols:
        machine.call("setup")
    return machine


def check(machine):
    if "bench_check" in machine.image.symbols:
        wrong = machine.call("bench_check")
        if wrong:
            raise SystemExit(f"{machine.image.path}: bench_check() says {wrong} (see image.h)")


def measure(machine, name, target=None, calls=400, warm=100, memory=True, of=None):
    """What the counted calls of one function took. The machine is one after setup() and has not
    called this function yet. With the Places of its image also where the cycles go."""
    for k in range(warm):
        machine.call(name, k)
    machine.watch(memory)
    runs = [machine.traced_call(name, warm + k, target) for k in range(calls)]
    machine.look_away()
    executed = set().union(*(run.addresses() for run in runs))
    functions = {machine.image.owner(address) for address in executed}
    found = {
        "instructions": spread([run.instructions for run in runs]),
        "executed": sum(machine.decoded[address].size for address in executed),
        "lines": len({address // LINE for address in executed}),
        "text": sum(function.size for function in functions),
    }
    if machine.core == "m4f":
        found["cycles"] = spread(list(cycles_of_all(runs)))
    if of is not None:
        found["kinds"], found["parts"] = places.mean(runs, of)
    if memory:
        found["loads"] = spread([run.loads for run in runs])
        found["stores"] = spread([run.stores for run in runs])
        found["ram"] = len(set().union(*(run.touched for run in runs)))
        found["stack"] = STACK_TOP - min(run.low for run in runs)
    return found


def cycles_of_all(runs):
    known = {}  # most runs take one of few paths
    for run in runs:
        key = tuple(run.trace)
        if key not in known:
            known[key] = cycles_of(run.trace)
        yield known[key]


def main():
    parser = argparse.ArgumentParser(description=__doc__, usage=__doc__.split("\n", maxsplit=1)[0])
    parser.add_argument("elf")
    parser.add_argument("function")
    parser.add_argument("--target", help="count this function, called once inside")
    parser.add_argument("--core", default="m4f")
    parser.add_argument("-n", type=int, default=400, dest="calls")
    parser.add_argument("--warm", type=int, default=100)
    options = parser.parse_args()
    machine = start(Image(options.elf), options.core)
    found = measure(machine, options.function, options.target, options.calls, options.warm)
    check(machine)
    print(json.dumps(found, indent=1))


if __name__ == "__main__":
    main()
