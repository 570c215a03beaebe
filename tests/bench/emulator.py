"""Runs functions of an ELF image in Unicorn and says which instructions they executed."""
import struct
from collections import namedtuple

from capstone import CS_MODE_ARM, CS_MODE_MCLASS, CS_MODE_THUMB
from elftools.elf.elffile import ELFFile
from unicorn import (UC_ARCH_ARM, UC_HOOK_CODE, UC_HOOK_MEM_READ, UC_HOOK_MEM_WRITE, UC_MODE_ARM,
                     UC_MODE_MCLASS, UC_MODE_THUMB, Uc, UcError)
from unicorn import arm_const as reg

from m4 import Decoder, Executed

FLASH, RAM, SIZE = 0x00000000, 0x20000000, 0x00400000
STACK_TOP = RAM + SIZE - 64
STACK_SIZE = 0x10000
RETURN_TO = FLASH + SIZE - 0x1000  # code never gets there by itself
IT_BITS = 0x0600FC00               # of xPSR: what is left of an IT block

CORES = {
    "m0": reg.UC_CPU_ARM_CORTEX_M0,
    "m3": reg.UC_CPU_ARM_CORTEX_M3,
    "m4f": reg.UC_CPU_ARM_CORTEX_M4,
    "m7": reg.UC_CPU_ARM_CORTEX_M7,
    "m33": reg.UC_CPU_ARM_CORTEX_M33,
    "r5f": reg.UC_CPU_ARM_CORTEX_R5F,
}
Function = namedtuple("Function", "name start size thumb")


class Image:
    def __init__(self, path):
        self.path = path
        with open(path, "rb") as file:
            elf = ELFFile(file)
            self.segments = [(s["p_vaddr"], s.data()) for s in elf.iter_segments()
                             if s["p_type"] == "PT_LOAD" and s["p_filesz"]]
            symbols = [s for s in elf.get_section_by_name(".symtab").iter_symbols()]
        self.symbols = {s.name: s["st_value"] for s in symbols}
        self.functions = sorted({Function(s.name, s["st_value"] & ~1, s["st_size"],
                                          bool(s["st_value"] & 1)) for s in symbols
                                 if s["st_info"]["type"] == "STT_FUNC"}, key=lambda f: f.start)
        self.objects = {s.name: s["st_size"] for s in symbols
                        if s["st_info"]["type"] == "STT_OBJECT"}

    def owner(self, address):
        for function in self.functions:
            if function.start <= address < function.start + max(function.size, 2):
                return function
        return Function(f"{address:#x}", address, 0, True)


class Run:
    """One call: `trace` of Executed, `low` the lowest stack address, `touched` RAM addresses."""

    def __init__(self, trace):
        self.trace = trace
        self.loads = self.stores = 0
        self.low = STACK_TOP
        self.touched = set()

    @property
    def instructions(self):
        return len(self.trace)

    def addresses(self):
        return {step.instruction.address for step in self.trace}


class Machine:
    def __init__(self, image, core):
        self.image, self.core = image, core
        profile_m = core.startswith("m")
        self.decoders = {True: Decoder(CS_MODE_THUMB | (CS_MODE_MCLASS if profile_m else 0)),
                         False: Decoder(CS_MODE_ARM)}
        self.decoded, self.blocks, self.endings = {}, {}, set()
        self.uc = Uc(UC_ARCH_ARM, UC_MODE_THUMB | UC_MODE_MCLASS if profile_m else UC_MODE_ARM)
        self.uc.ctl_set_cpu_model(CORES[core])
        self.uc.mem_map(FLASH, SIZE)
        self.uc.mem_map(RAM, SIZE)
        for address, data in image.segments:
            self.uc.mem_write(address, data)
        if not profile_m:  # switch the FPU on, which the M cores' models have done
            self.uc.reg_write(reg.UC_ARM_REG_C1_C0_2, 0xF << 20)
            self.uc.reg_write(reg.UC_ARM_REG_FPEXC, 1 << 30)
        self.uc.mem_write(RETURN_TO, struct.pack("<HH", 0xE7FE, 0xE7FE))
        self.pcs, self.bits, self.run, self.hooks = [], {}, Run([]), []

    def call(self, name, argument=0):
        """Runs a function at full speed and returns its r0."""
        uc = self.uc
        uc.reg_write(reg.UC_ARM_REG_SP, STACK_TOP)
        uc.reg_write(reg.UC_ARM_REG_LR, RETURN_TO | (self.image.symbols.get(name, 0) & 1))
        uc.reg_write(reg.UC_ARM_REG_R0, argument)
        try:
            uc.emu_start(self.image.symbols[name], RETURN_TO)
        except KeyError:
            raise SystemExit(f"{self.image.path}: no function {name}") from None
        except UcError as error:
            pc = uc.reg_read(reg.UC_ARM_REG_PC)
            raise SystemExit(f"{name}: {error} at {pc:#x} in {self.image.owner(pc).name}") from None
        return uc.reg_read(reg.UC_ARM_REG_R0)

    def watch(self, memory=True):
        """From now on calls are traced; with `memory` their accesses too."""
        self.hooks.append(self.uc.hook_add(UC_HOOK_CODE, self._executed))
        if memory:
            kinds = UC_HOOK_MEM_READ | UC_HOOK_MEM_WRITE
            self.hooks.append(self.uc.hook_add(kinds, self._accessed))
        self.uc.ctl_flush_tb()

    def look_away(self):
        """From now on calls run at full speed again."""
        while self.hooks:
            self.uc.hook_del(self.hooks.pop())
        self.uc.ctl_flush_tb()

    def traced_call(self, name, argument=0, target=None):
        """The run of `target`, called once inside; of `name` itself without it. Needs watch()."""
        self.pcs, self.bits = [], {}
        self.run = Run([])
        self.call(name, argument)
        first, last = 0, len(self.pcs)
        if target is not None:
            first, last = self._inside(self.image.symbols[target] & ~1)
        self.run.trace = self._trace(first, last)
        return self.run

    def instruction(self, address):
        found = self.decoded.get(address)
        if found is None:
            decoder = self.decoders[self.image.owner(address).thumb]
            found = decoder.at(address, bytes(self.uc.mem_read(address, 4)))
            self.decoded[address] = found
            self._note_block(found)
        return found

    def _note_block(self, it):
        """The addresses of an IT block, from its IT to behind its end."""
        end = it.address + it.size
        if it.conditionals:
            inside = []
            for _ in range(it.conditionals):
                inside.append(end)
                end += self.instruction(end).size
            self.blocks.update(dict.fromkeys([it.address] + inside, end))
            self.endings.add(inside[-1])

    def _executed(self, uc, address, _size, _data):
        pcs = self.pcs
        this = self.instruction(address)
        if this.divided:
            self.bits[len(pcs)] = self._quotient_bits(this)
        # Unicorn 2.1 leaves the rest of an IT block in the processor's state when a hook was called
        # inside; the next block of code would start as if it were still in there.
        if pcs and (pcs[-1] in self.blocks and address not in self.blocks or address in self.endings):
            state = uc.reg_read(reg.UC_ARM_REG_XPSR)
            if state & IT_BITS:
                uc.reg_write(reg.UC_ARM_REG_XPSR, state & ~IT_BITS)
        pcs.append(address)

    def _accessed(self, _uc, access, address, size, _value, _data):
        run = self.run
        if access == 17:
            run.stores += 1
        else:
            run.loads += 1
        if STACK_TOP - STACK_SIZE <= address < STACK_TOP:
            run.low = min(run.low, address)
        elif address >= RAM:
            run.touched.update(range(address, address + size))

    def _quotient_bits(self, this):
        values = [self.uc.reg_read(getattr(reg, f"UC_ARM_REG_{name.upper()}"))
                  for name in this.divided]
        if this.mnemonic.startswith("sdiv"):
            values = [value - (1 << 32) if value >> 31 else value for value in values]
        return (abs(values[0]) // abs(values[1])).bit_length() if values[1] else 0

    def _inside(self, start):
        """From the first instruction of a called function to its return."""
        pcs = self.pcs
        first = pcs.index(start)
        caller = self.instruction(pcs[first - 1])
        back = caller.address + caller.size
        if not caller.mnemonic.startswith("bl"):  # a tail call returns to the caller's caller
            return first, len(pcs)
        return first, pcs.index(back, first)

    def _trace(self, first, last):
        pcs, trace = self.pcs, []
        for k in range(first, last):
            this = self.instruction(pcs[k])
            following = pcs[k + 1] if k + 1 < len(pcs) else RETURN_TO
            behind = this.address + this.size
            skipped = []
            if behind < following <= self.blocks.get(this.address, 0):
                while behind < following:  # Unicorn does not report what an IT block skips
                    skipped.append(self.instruction(behind))
                    behind += skipped[-1].size
            trace.append(Executed(this, False, following != behind, self.bits.get(k, 0)))
            trace.extend(Executed(skip, True, False, 0) for skip in skipped)
        return trace
