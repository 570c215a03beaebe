#!/usr/bin/env python3
"""usage: check_cmd.py FILE.cmd SIZES

Adds the sections of the F28004x's image up against the memories of its linker command file. No free
compiler makes code for a C28x, so SIZES (lines of `arm-none-eabi-size -A`) is the same application for a
Cortex-R5F in Arm state, whose instructions of 32 bits are the larger ones. MARGIN is for what differs:
bool and uint_least8_t of 16 bits, TI's library. Prints the shares; exit 1 where something does not fit.
"""
import re
import sys

MARGIN = 1.25
# SPRS945, memory map: first and one past the last word, without what boot ROM and errata reserve.
CHIP = {"M0, M1": (0xF6, 0x7F8), "LS0 .. LS7": (0x8000, 0xC000), "GS0 .. GS3": (0xC000, 0x13FF8),
        "flash": (0x80000, 0x9FFF0), "reset vector": (0x3FFFC0, 0x3FFFC2)}


def without_comments(text):
    return re.sub(r"/\*.*?\*/", "", text, flags=re.S)


def memories(text):
    block = re.search(r"MEMORY\s*{(.*?)}", text, re.S).group(1)
    found = re.findall(r"(\w+)\s*:\s*origin\s*=\s*(\w+)\s*,\s*length\s*=\s*(\w+)", block)
    return {name: (int(origin, 0), int(origin, 0) + int(length, 0)) for name, origin, length in found}


def placements(text):
    """Section -> the memories that each have it all, or, split over several, a list of those."""
    block = re.search(r"SECTIONS\s*{(.*)}", text, re.S).group(1)
    found = {}
    for name, rest in re.findall(r"([.\w]+)\s*:\s*((?:>|LOAD).*?)(?=\n\s*[.\w]+\s*:|\Z)", block, re.S):
        plain = re.match(r">\s*(\w+)", rest)
        split = re.match(r">>\s*(\w+(?:\s*\|\s*\w+)*)", rest)
        load = re.search(r"LOAD\s*=\s*(\w+)", rest)
        run = re.search(r"RUN\s*=\s*(\w+)", rest)
        if split:
            found[name] = re.findall(r"\w+", split.group(1))
        else:
            found[name] = (plain.group(1),) * 2 if plain else (load.group(1), run.group(1))
    return found


def words_of(sizes_path, stack):
    sizes = {}
    with open(sizes_path, encoding="ascii") as lines:
        for line in lines:
            fields = line.split()
            if len(fields) == 3 and fields[1].isdigit():
                sizes[fields[0]] = int(fields[1])

    def words(*names):
        return round(MARGIN * sum(sizes.get(n, 0) for n in names) / 2)

    return {".text": words(".text", ".ARM.exidx"), ".TI.ramfunc": words(".hot"),
            ".bss": words(".bss", ".data"), ".TI.noinit": words(".noinit"), ".stack": stack}


def main(cmd_path, sizes_path):
    with open(cmd_path, encoding="ascii") as file:
        text = without_comments(file.read())
    wrong = []
    ranges = memories(text)
    for name, (first, end) in ranges.items():
        if not any(low <= first and end <= high for low, high in CHIP.values()):
            wrong.append(f"{name}: 0x{first:X} .. 0x{end - 1:X} is no memory of the chip that is free")
        for other, (low, high) in ranges.items():
            if other != name and first < high and low < end:
                wrong.append(f"{name} and {other} overlap")
    stack = re.search(r"--stack_size=(\w+)", text)
    if not stack:
        wrong.append("no --stack_size")
    wanted = words_of(sizes_path, int(stack.group(1), 0) if stack else 0)
    where = placements(text)
    for section in list(wanted) + [".cinit", ".const", ".switch", ".init_array", ".data", "codestart"]:
        if section not in where:
            wrong.append(f"{section} stands nowhere")
    used = dict.fromkeys(ranges, 0)
    length_of = {name: end - first for name, (first, end) in ranges.items()}
    # What may be split takes what the others leave.
    for section, words in sorted(wanted.items(), key=lambda item: isinstance(where.get(item[0]), list)):
        memories_of = where.get(section, ())
        if not isinstance(memories_of, list):
            for memory in set(memories_of):
                used[memory] += words
            continue
        for memory in memories_of[:-1]:
            part = min(words, length_of[memory] - used[memory])
            used[memory] += part
            words -= part
        used[memories_of[-1]] += words
    for memory, words in used.items():
        length = length_of[memory]
        if words:
            print(f"f28004x: {memory} {words} of {length} words")
        if words > length:
            wrong.append(f"{memory}: {words} words do not fit {length}")
    for line in wrong:
        print(f"{cmd_path}: {line}", file=sys.stderr)
    return 1 if wrong else 0


if __name__ == "__main__":
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    sys.exit(main(sys.argv[1], sys.argv[2]))
