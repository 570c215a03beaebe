"""usage: fuzz_seeds.py unpack FILE FOLDER | fuzz_seeds.py pack FOLDER FILE

FILE holds the seeds of a fuzzer, one on each line in hexadecimal, with its name behind a blank where it has one.
unpack: writes each as a file of the folder, which is made anew. pack: the reverse, by name and then by size.
"""
import pathlib
import re
import shutil
import sys


def unpack(file, folder):
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    for number, line in enumerate(file.read_text().splitlines(), 1):
        if not re.fullmatch(r"([0-9a-f]{2})*( [\w-]+)?", line):
            sys.exit(f"{file}:{number}: expected octets in hexadecimal, and a name at most")
        octets, _, name = line.partition(" ")
        (folder / (name or f"{number:04}")).write_bytes(bytes.fromhex(octets))


def pack(folder, file):
    seeds = []
    for path in folder.iterdir():
        named = not re.fullmatch(r"[0-9a-f]{40}|\d{4}", path.name)  # as libFuzzer calls them, or unpack() does
        seeds.append((not named, path.name if named else "", len(octets := path.read_bytes()), octets))
    file.write_text("".join(f"{octets.hex()} {name}".rstrip() + "\n" for _, name, _, octets in sorted(seeds)))


if __name__ == "__main__":
    if len(sys.argv) != 4 or sys.argv[1] not in ("unpack", "pack"):
        sys.exit(__doc__)
    {"unpack": unpack, "pack": pack}[sys.argv[1]](pathlib.Path(sys.argv[2]), pathlib.Path(sys.argv[3]))
