"""Modelled cycles of a Cortex-M4F for a known sequence of instructions; cortex_m4.txt has the figures.

A trace is a list of Executed: what ran, in order, instructions skipped in an IT block included.
"""
import pathlib
import re
from collections import namedtuple

from capstone import CS_ARCH_ARM, CS_MODE_MCLASS, CS_MODE_THUMB, Cs
from capstone.arm import ARM_OP_MEM, ARM_OP_REG

TABLE = pathlib.Path(__file__).with_name("cortex_m4.txt")
REFILL = 2       # cycles to refill the pipeline after a taken branch; the manual: 1 to 3
DIVIDER = 14     # cycles of VDIV and VSQRT
DIVIDE_MAX = 10  # of SDIV and UDIV, beyond their least
BITS_PER_CYCLE = 3

Row = namedtuple("Row", "name cycles rules")
# taken: the next instruction is not the one behind; bits: length of the quotient of a division.
Executed = namedtuple("Executed", "instruction skipped taken bits")


def read_table(path=TABLE):
    rows = {}
    for line in path.read_text().splitlines():
        if line.strip() and not line.startswith("#"):
            name, cycles, rules, *mnemonics = line.split()
            row = Row(name, int(cycles), frozenset(rules.split(",")) - {"-"})
            rows.update((mnemonic, row) for mnemonic in mnemonics)
    return rows


ROWS = read_table()


def words_of(register):
    """The 32-bit registers that a name stands for: d4 is s8 and s9."""
    if re.fullmatch(r"d\d+", register):
        first = 2 * int(register[1:])
        return {f"s{first}", f"s{first + 1}"}
    return {register}


class Instruction:
    """What the model needs to know of one instruction, whatever it works on."""

    def __init__(self, address, insn):
        self.address, self.size = address, insn.size
        self.mnemonic = insn.mnemonic.split(".")[0]
        self.row = self._row(insn)
        registers = [insn.reg_name(op.reg) for op in insn.operands if op.type == ARM_OP_REG]
        self.moved = self._moved(registers)
        memory = [op.mem for op in insn.operands if op.type == ARM_OP_MEM]
        self.indexed = any(mem.index for mem in memory)
        self.divided = registers[-2:] if "divide" in self.row.rules else None
        read, written = insn.regs_access()
        self.reads = set().union(*(words_of(insn.reg_name(r)) for r in read))
        self.writes = set().union(*(words_of(insn.reg_name(r)) for r in written))
        self.fpu = self.mnemonic.startswith("v")
        self.conditionals = len(self.mnemonic) - 1 if self.row.name == "it" else 0

    def _row(self, insn):
        """In an IT block (and for branches) the disassembler may add a condition to the name."""
        name = self.mnemonic
        if name not in ROWS and name[:-2] in ROWS and insn.cc not in (0, 15):
            name = name[:-2]
        return ROWS.get(name, ROWS["*"])

    def _moved(self, registers):
        words = sum(len(words_of(register)) for register in registers)
        if self.mnemonic in ("ldrd", "strd"):
            return 2
        if self.mnemonic.startswith(("ldm", "stm", "vldm", "vstm")):
            return words - 1  # the base
        return words


class Decoder:
    def __init__(self, mode=CS_MODE_THUMB | CS_MODE_MCLASS):
        self.capstone = Cs(CS_ARCH_ARM, mode)
        self.capstone.detail = True

    def at(self, address, raw):
        insn = next(self.capstone.disasm(raw, address, 1), None)
        if insn is None:
            raise SystemExit(f"{address:#x}: {raw.hex()} is not an instruction")
        return Instruction(address, insn)


def own_cycles(this, single_before, bits):
    """Cycles of one executed instruction without branch and waiting, and whether it is a single
    load or store that shortens the next."""
    rules, cycles = this.row.rules, this.row.cycles
    if "words" in rules:
        return cycles + this.moved, False
    if "words-of-two" in rules:
        return cycles + (this.moved == 4), False
    if "wide" in rules:
        return cycles + (this.moved == 2), False
    if "divide" in rules:
        return cycles + min(DIVIDE_MAX, -(-bits // BITS_PER_CYCLE)), False
    if "indexed" in rules and this.indexed:
        return (1 if single_before else 2), False
    if "paired" in rules:
        return (1 if single_before else cycles), True
    return cycles, False


def timed(trace):
    """Of each instruction of a trace: itself, its own cycles, those of the pipeline's refill behind
    it, those of waiting for the divider. Their sum is the total up to the end of the last one."""
    now = divider_free = 0
    single = False
    before = None  # the instruction whose result may come late
    for step in trace:
        this, skipped, taken, bits = step
        wait = divider_free - now if this.fpu and now < divider_free else 0
        if skipped:
            cycles, single = 1, False
        else:
            late = before is not None and "late" in before.row.rules and before.writes & this.reads
            if "hidden" in this.row.rules:
                divider_free = now + wait + bool(late) + DIVIDER
            cycles, single = own_cycles(this, single, bits)
            cycles += bool(late)
        before = None if skipped else this
        refill = REFILL if taken and not skipped else 0
        now += wait + cycles + refill
        yield step, cycles, refill, wait
    if trace and now < divider_free:
        yield trace[-1], 0, 0, divider_free - now


def cycles_of(trace):
    """Total of a trace, up to the end of its last instruction."""
    return sum(cycles + refill + wait for _, cycles, refill, wait in timed(trace))
