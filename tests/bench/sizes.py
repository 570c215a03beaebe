"""What a firmware with one drive takes of flash and RAM: from an image linked with --emit-relocs and
its map."""
import re
from collections import namedtuple

from elftools.elf.elffile import ELFFile

from emulator import Image

OWN = "firmware"  # prefix of what belongs to the measurement, not to the library
INPUT = re.compile(r"^ (\.\S+)\s+(0x[0-9a-f]+)\s+(0x[0-9a-f]+) (\S.*)$")

Section = namedtuple("Section", "name address size file")


def input_sections(map_path):
    """The input sections that a linker map places in flash."""
    text = map_path.read_text().split("Linker script and memory map", 1)[1]
    text = re.sub(r"^( \.\S+)\n\s+", r"\1 ", text, flags=re.M)  # long names have a line of their own
    for line in text.splitlines():
        match = INPUT.match(line)
        if match:
            name, address, size, file = match.groups()
            if int(size, 16) and re.match(r"\.(text|rodata|data|ARM\.ex)", name):
                yield Section(name, int(address, 16), int(size, 16), file)


def references(path):
    """Which function refers to which other ones."""
    image, found = Image(path), {}
    with open(path, "rb") as file:
        elf = ELFFile(file)
        symbols = elf.get_section_by_name(".symtab")
        for relocation in elf.get_section_by_name(".rel.text").iter_relocations():
            symbol = symbols.get_symbol(relocation["r_info_sym"])
            if symbol["st_info"]["type"] == "STT_FUNC":
                caller = image.owner(relocation["r_offset"]).name
                found.setdefault(caller, set()).add(image.owner(symbol["st_value"] & ~1).name)
    return found


def reachable(path, start):
    calls, seen, new = references(path), set(), {start}
    while new:
        seen |= new
        new = set().union(*(calls.get(name, set()) for name in new)) - seen
    return seen


def firmware_sizes(path, step="lode_drive_step"):
    image = Image(path)
    # With -flto it may have a suffix.
    on_path = reachable(path, next(f.name for f in image.functions if f.name.split(".")[0] == step))
    sizes = dict.fromkeys(("step", "init", "constants", "libraries"), 0)
    for section in input_sections(path.with_suffix(".map")):
        names = {f.name for f in image.functions
                 if section.address <= f.start < section.address + section.size}
        if any(name.startswith(OWN) for name in names) or section.name.startswith(f".data.{OWN}"):
            continue
        if ".a(" in section.file:
            sizes["libraries"] += section.size
        elif not section.name.startswith(".text"):
            sizes["constants"] += section.size
        else:
            sizes["step" if names & on_path else "init"] += section.size
    sizes["text"] = sum(sizes.values())
    for what in ("drive", "tuning", "config"):
        sizes[what] = image.objects.get(f"{OWN}_{what}", 0)  # 0: not needed
    return sizes


def object_sizes(path):
    """Bytes of each type, from the object file of build.objects()."""
    with open(path, "rb") as file:
        symbols = ELFFile(file).get_section_by_name(".symtab").iter_symbols()
        return {symbol.name.removeprefix("size_"): symbol["st_size"] for symbol in symbols
                if symbol.name.startswith("size_")}
