"""Where the modelled cycles of a step go: by kind of instruction, and by part of the step.

A part is a set of functions of the source. Most of them are inlined: the debugging information says
from which function an instruction comes, although the compiler has mixed them.
"""
import bisect
from collections import Counter

from elftools.dwarf.ranges import BaseAddressEntry
from elftools.elf.elffile import ELFFile

from m4 import timed

KINDS = {
    "arithmetic of the FPU, moves and comparisons": {"fpu", "fpu_mac", "fpu_compare", "fpu_move"},
    "FPU loads and stores": {"fpu_load"},
    "integer loads and stores": {"load", "store"},
    "integer arithmetic, conditions": {"integer", "it"},
    "divisions and square roots": {"fpu_divide", "quotient"},
    "branches, calls": {"table"},
    "registers saved and restored": {},
}
DIVISION, BRANCH, SAVED = "divisions and square roots", "branches, calls", "registers saved and restored"
BRANCHES = ("b", "bl", "blx", "bx", "cbz", "cbnz")

# The innermost of these functions that an instruction comes from decides. What comes from none of
# them, as the copies between them do, is OTHER.
COMMON = {
    "sensing, with the voltage that acted": {
        "sense", "lode_sense_next", "lode_sense_currents", "lode_sense_sample",
        "lode_inverter_realised", "lode_inverter_follow_bus"},
    "EMF observer": {"lode_observer_step_called", "lode_estimator_emf", "lode_estimator_dead_beat"},
    "PLL": {"lode_estimator_fast", "lode_estimator_period", "lode_estimator_acceleration", "lode_pll_predict",
            "lode_pll_correct", "lode_pll_correct_disturbance"},
    "current control": {"lode_drive_control", "lode_current_step"},
    "modulation": {"modulate", "lode_modulator_step", "lode_modulator6_step",
                   "lode_modulator_set"},
    "speed control, references": {"lode_drive_speed", "lode_drive_references"},
}
MORE = {
    "correction of the dead time": {"lode_modulator_errors", "lode_inverter_error"},
    "compensation of the lag": {"lode_estimator_rotor", "lode_estimator_adapt_lag"},
    "notch": {"lode_estimator_notched", "lode_estimator_adapt_notches"},
    "guard": {"lode_guard_all_ok", "lode_drive_guard", "lode_modulator_is_within"},
    "slow parts": {"lode_drive_slow_job", "lode_estimator_note_lock", "lode_estimator_adapt_gains",
                   "lode_drive_lead", "lode_inverter_adapt", "lode_xy_adapt"},
    "control of the xy plane": {"lode_xy_step", "voltages"},
    "watch on open phases": {"watch_phases", "lode_open_phase_doubts"},
}
OTHER = "entry, exit, modes, copies"
PARTS = [*COMMON, *MORE, OTHER]
PART_OF = {name: part for group in (COMMON, MORE) for part, names in group.items() for name in names}


def kind_of(this):
    if this.mnemonic in ("push", "pop", "vpush", "vpop"):
        return SAVED
    if this.mnemonic.startswith(("vldm", "vstm")):
        return "FPU loads and stores"
    if this.row.name == "multiple":
        return "integer loads and stores"
    if this.mnemonic in BRANCHES or this.mnemonic[:-2] in BRANCHES and this.row.name == "integer":
        return BRANCH
    return next(kind for kind, rows in KINDS.items() if this.row.name in rows)


class Places:
    """Of every address of an image the function in the source."""

    def __init__(self, image):
        self.starts, self.parts = [], []
        known = {function.start for function in image.functions}
        spans = []
        with open(image.path, "rb") as file:
            dwarf = ELFFile(file).get_dwarf_info()
            self.ranges = dwarf.range_lists()
            for unit in dwarf.iter_CUs():
                for entry in unit.get_top_DIE().iter_children():
                    low = entry.attributes.get("DW_AT_low_pc")
                    if entry.tag == "DW_TAG_subprogram" and low and low.value in known:
                        self._collect(entry, None, 0, spans)
        edges = {edge for first, last, _, _ in spans for edge in (first, last)}
        inner = sorted(spans, key=lambda span: span[2])
        for edge in sorted(edges):
            self.starts.append(edge)
            self.parts.append(None)
        for first, last, _, part in inner:
            for k in range(bisect.bisect_left(self.starts, first),
                           bisect.bisect_left(self.starts, last)):
                self.parts[k] = part

    def _collect(self, entry, part, depth, spans):
        if entry.tag in ("DW_TAG_subprogram", "DW_TAG_inlined_subroutine"):
            part = PART_OF.get(self._name(entry), part)
            spans.extend((first, last, depth, part) for first, last in self._extent(entry))
        for child in entry.iter_children():
            self._collect(child, part, depth + 1, spans)

    @staticmethod
    def _name(entry):
        while "DW_AT_abstract_origin" in entry.attributes:
            entry = entry.get_DIE_from_attribute("DW_AT_abstract_origin")
        return entry.attributes["DW_AT_name"].value.decode()

    def _extent(self, entry):
        attributes = entry.attributes
        if "DW_AT_low_pc" in attributes:
            low, high = attributes["DW_AT_low_pc"].value, attributes["DW_AT_high_pc"]
            yield low, high.value + (low if high.form != "DW_FORM_addr" else 0)
        elif "DW_AT_ranges" in attributes:
            base = entry.cu.get_top_DIE().attributes["DW_AT_low_pc"].value
            for span in self.ranges.get_range_list_at_offset(attributes["DW_AT_ranges"].value):
                if isinstance(span, BaseAddressEntry):
                    base = span.base_address
                else:
                    yield base + span.begin_offset, base + span.end_offset

    def part(self, address):
        """None: of no part; in a function that was called, then that of its caller."""
        k = bisect.bisect_right(self.starts, address) - 1
        return self.parts[k] if k >= 0 else None


def of_trace(trace, places):
    kinds, parts = Counter(), Counter()
    callers = []  # return address, part of the caller
    for executed, cycles, refill, wait in timed(trace):
        this = executed.instruction
        while callers and this.address == callers[-1][0]:
            callers.pop()
        part = places.part(this.address) or (callers[-1][1] if callers else OTHER)
        kinds[kind_of(this)] += cycles
        kinds[BRANCH] += refill
        kinds[DIVISION] += wait
        parts[part] += cycles + refill + wait
        if executed.taken and this.mnemonic in ("bl", "blx"):
            callers.append((this.address + this.size, part))
    return kinds, parts


def mean(runs, places):
    """Cycles per run by kind and by part."""
    known, kinds, parts = {}, Counter(), Counter()
    for run in runs:
        key = tuple(run.trace)
        if key not in known:
            known[key] = of_trace(run.trace, places)
        kinds.update(known[key][0])
        parts.update(known[key][1])
    return ({kind: round(kinds[kind] / len(runs), 1) for kind in KINDS},
            {part: round(parts[part] / len(runs), 1) for part in PARTS})
