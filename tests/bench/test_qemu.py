"""A second counter: QEMU's SysTick, which under -icount shift=6 sees 64 ns per instruction."""
import shutil
import subprocess
import sys

import build

try:
    import count
    from emulator import Image
except ImportError as error:
    print(f"skipped: {error} (tests/run tries to install it)")
    sys.exit(77)

QEMU = "qemu-system-arm"
WARM, CALLS = 100, 300           # as in qemu.c
INSTRUCTIONS_PER_TICK = 40 / 64  # the board's clock is 25 MHz
OVERHEAD = 3                     # instructions per call that are counted on one side only
OPTIONS = ["-display", "none", "-monitor", "none", "-serial", "none", "-chardev", "stdio,id=out",
           "-semihosting-config", "enable=on,target=native,chardev=out",
           "-icount", "shift=6,sleep=off"]


def ticks_of(elf):
    done = subprocess.run([QEMU, "-M", "mps2-an386", *OPTIONS, "-kernel", str(elf)],
                          capture_output=True, text=True, timeout=120, stdin=subprocess.DEVNULL)
    return {name: int(value) for name, value in (line.split() for line in done.stdout.splitlines())}


def main():
    lack = build.missing() or (None if shutil.which(QEMU) else f"no {QEMU}")
    if lack:
        print(f"skipped: {lack}")
        return 77
    elf = build.image(tables=build.recording())
    ticks = ticks_of(elf)
    if ticks.pop("check", 1) or not ticks:
        print(f"the image found itself wrong in {QEMU}: {ticks}")
        return 1
    machine = count.start(Image(elf))
    wrong = 0
    for name, value in ticks.items():
        there = value * INSTRUCTIONS_PER_TICK / CALLS
        here = count.measure(machine, f"bench_{name}", None, CALLS, WARM, memory=False)
        here = here["instructions"]["avg"]
        bad = abs(there - here) > OVERHEAD
        wrong += bad
        print(f"{name}: {there:.1f} instructions per call in {QEMU}, {here:.1f} in Unicorn"
              + (f": expected the same within {OVERHEAD}" if bad else ""))
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
