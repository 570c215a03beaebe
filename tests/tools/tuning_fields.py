"""usage: tuning_fields.py: prints sim/design/tuning_fields.h, every scalar of a lode_drive_tuning_t and of a
lode_drive_config_t, from the headers in include/lodestar. A member that would leave padding on some machine ends it: a
tuning, that of six phases too, is made of floats, 32-bit integers and pairs of 16-bit ones. A configuration is made of
floats and enumerations."""
import pathlib
import re
import sys

from csource import code_of

INCLUDE = pathlib.Path(__file__).resolve().parents[2] / "include" / "lodestar"
TOP = "lode_drive_tuning_t"
TOP_6 = "lode_drive6_tuning_t"
CONFIG = "lode_drive_config_t"
CONFIG_6 = "lode_drive6_config_t"
HALF = "uint_least16_t"
SCALARS = {"float": "FLOAT", "int32_t": "INTEGER", "uint32_t": "WHOLE", HALF: "WHOLE"}
STRUCT = re.compile(r"typedef struct \{([^{}]*)\} (\w+);")
ENUM = re.compile(r"typedef enum \{([^{}]*)\} (\w+);")
MEMBER = re.compile(r"(\w+) (\w+)(?:\[([\w()]+)\])?")
ALIAS = re.compile(r"typedef (lode_\w+) (lode_\w+);")
OBSERVER = re.compile(r"^LODE_OBSERVER\((\w+),.*, (\d+)\)$", re.M)
OBSERVER_FIELD = re.compile(r"^LODE_OBSERVER_FIELD\((\w+)\)$", re.M)

text = "\n".join(code_of(path.read_text()) for path in sorted(INCLUDE.glob("*.h")))
structs = {name: body for body, name in STRUCT.findall(text)}
enums = {name: re.findall(r"^\s*(LODE_\w+)", body.replace(",", "\n"), re.M) for body, name in ENUM.findall(text)}
constants = dict(re.findall(r"#define (LODE_\w+) (\d+)\s", text))
observers = (INCLUDE / "observers.def").read_text()
constants["sizeof(lode_observer_numbers_t)"] = max(int(number) for _, number in OBSERVER.findall(observers))
enums["lode_emf_kind_t"] = [f"LODE_EMF_{name}" for name, _ in OBSERVER.findall(observers)]
structs["lode_observer_config_t"] += "".join(f"float {name};" for name in OBSERVER_FIELD.findall(observers))
structs.update((name, structs[kind]) for kind, name in ALIAS.findall(text) if kind in structs)


def members(struct):
    """(type, name, number of elements or None) of each."""
    body = re.sub(r"^#.*", "", structs[struct], flags=re.M)  # what a build may leave out is there
    for line in body.split(";"):
        line = " ".join(line.split())
        if line:
            match = MEMBER.fullmatch(line)
            if match is None:
                sys.exit(f"{struct}: `{line}` is no member that this script can read")
            kind, name, count = match.groups()
            yield kind, name, count and int(constants.get(count, count))


def options(struct, prefix=""):
    """(place, name of the option LODE_WITHOUT_... that leaves it out)."""
    option = None
    for part in re.findall(r"^#.*|[^;#]+;", structs[struct], re.M):  # directives and members
        begins = re.match(r"#ifndef LODE_WITHOUT_(\w+)", part)
        if part.startswith("#"):
            option = begins and begins.group(1)
            continue
        kind, name = MEMBER.match(" ".join(part.split())).group(1, 2)
        if option:
            yield f'"{prefix}{name}"', f'"{option}"'
        elif kind in structs:
            yield from options(kind, f"{prefix}{name}.")


def scalars(struct, prefix=""):
    halves = 0
    for kind, name, count in members(struct):
        if kind != HALF and halves % 2 != 0:
            sys.exit(f"{struct}.{name}: comes after a single {HALF}, expected pairs")
        halves += int(kind == HALF)
        for place in [name] if count is None else [f"{name}[{k}]" for k in range(count)]:
            if kind in structs:
                yield from scalars(kind, f"{prefix}{place}.")
            elif kind in SCALARS:
                # How many numbers of its tuning an observer uses depends on which it is.
                used = (SCALARS[kind], kind)
                if struct == "lode_observer_tuning_t" and count:
                    used = ("OBSERVER", re.search(r"\d+", place).group())
                yield *used, prefix + place
            else:
                sys.exit(f"{struct}.{name}: {kind}, expected one of {', '.join(SCALARS)}")
    if halves % 2 != 0:
        sys.exit(f"{struct}: ends in a single {HALF}, expected pairs")


def choices(struct, prefix=""):
    """(kind, type, member) of a configuration."""
    for kind, name, count in members(struct):
        if kind in structs and count is None:
            yield from choices(kind, f"{prefix}{name}.")
        elif count is None and (kind == "float" or kind in enums):
            yield "FLOAT" if kind == "float" else "CHOICE", kind, prefix + name
        else:
            sys.exit(f"{struct}.{name}: {kind}, expected float or an enumeration")


def table(name, rows):
    print(f"\n#define {name}(ROW) \\\n" + " \\\n".join(f"    ROW({', '.join(row)})" for row in rows))


print("// Printed by tests/tools/tuning_fields.py from the headers; the test gate_tuning_fields compares.")
print("// ROW(kind, type, member) of every scalar of a lode_drive_tuning_t; OBSERVER: the place for the type. TUNING6_FIELDS: of")
print("// those that a lode_drive6_tuning_t has besides two of these. CONFIG_FIELDS, CONFIG6_FIELDS: the same of the configurations;")
print("// CHOICE: an enumeration, and CONFIG_CHOICES(type, enumerator): what it may be.")
print("// TUNING_OPTIONS(place, option): the members of a lode_drive_tuning_t that LODE_WITHOUT_<option> leaves out.")
print("// clang-format off")
print("#ifndef RIG_TUNING_FIELDS_H\n#define RIG_TUNING_FIELDS_H")
table("TUNING_FIELDS", scalars(TOP))
table("TUNING6_FIELDS", [row for row in scalars(TOP_6) if not row[2].startswith(("drive.", "alone."))])
table("TUNING_OPTIONS", options(TOP))
config = list(choices(CONFIG))
config6 = [row for row in choices(CONFIG_6) if not row[2].startswith("drive.")]
table("CONFIG_FIELDS", config)
table("CONFIG6_FIELDS", config6)
used = dict.fromkeys(type_ for kind, type_, _ in config + config6 if kind == "CHOICE")
table("CONFIG_CHOICES", [(type_, name) for type_ in used for name in enums[type_]])
print("\n#endif")
