"""The counter and its cycle model on hand-written sequences whose cycles the manual gives."""
import pathlib
import sys
import tempfile

import build

try:
    import count
    from emulator import Image
except ImportError as error:
    print(f"skipped: {error} (tests/run tries to install it)")
    sys.exit(77)

RETURN = 1 + 2  # bx lr

# name: assembly, cycles by hand without the return, instructions without it
SEQUENCES = {
    "integers": ("movs r1, #1; adds r1, r1, #2; muls r1, r0, r1", 1 + 1 + 1, 3),
    "loop": ("movs r1, #10; 1: subs r1, r1, #1; bne 1b", 1 + 10 * 1 + 9 * (1 + 2) + 1, 21),
    "loads_in_a_row": ("ldr r1, [sp]; ldr r2, [sp]; ldr r3, [sp]", 2 + 1 + 1, 3),
    "loads_apart": ("ldr r1, [sp]; movs r2, #0; ldr r3, [sp]", 2 + 1 + 2, 3),
    "stores": ("str r1, [sp, #-8]; str r1, [sp, #-8]", 1 + 1, 2),
    "stack": ("push {r4-r7, lr}; pop {r4-r7, lr}", 2 * (1 + 5), 2),
    "pair": ("ldrd r1, r2, [sp]; ldmia sp, {r1-r3}", 1 + 2 + 1 + 3, 2),
    "division": ("movs r1, #100; movs r2, #7; udiv r3, r1, r2", 1 + 1 + (2 + 2), 3),  # 14: 4 bits
    "taken_and_not": ("cmp r0, r0; bne 1f; b 1f; nop; 1:", 1 + 1 + 3, 3),
    "it_block": ("cmp r0, r0; ite eq; moveq r1, #1; movne r1, #2", 1 + 1 + 1 + 1, 4),
    "it_load_skipped": ("cmp r0, r0; it ne; ldrne r1, [sp]", 1 + 1 + 1, 3),
    "it_load_taken": ("cmp r0, r0; it eq; ldreq r1, [sp]", 1 + 1 + 2, 3),
    "call": ("mov r3, lr; bl 1f; b 2f; 1: bx lr; 2: mov lr, r3", 1 + 3 + 3 + 3 + 1, 5),
    "fpu": ("vmul.f32 s0, s1, s2; vadd.f32 s3, s4, s5", 1 + 1, 2),
    "fpu_result_at_once": ("vmul.f32 s0, s1, s2; vadd.f32 s3, s0, s5", 1 + 1 + 1, 2),
    "fpu_result_later": ("vmul.f32 s0, s1, s2; nop; vadd.f32 s3, s0, s5", 1 + 1 + 1, 3),
    "mac": ("vfma.f32 s0, s1, s2; vmla.f32 s3, s1, s2", 3 + 3, 2),
    "root": ("vsqrt.f32 s0, s1", 14 - RETURN, 1),  # the return goes on meanwhile
    "quotient_waited_for": ("vdiv.f32 s0, s1, s2; vadd.f32 s3, s4, s5", 14 + 1, 2),
    "quotient_hidden": ("vdiv.f32 s0, s1, s2; movs r1, #1; movs r2, #1; vadd.f32 s3, s4, s5",
                        14 + 1, 4),
    "fpu_memory": ("vldr s0, [sp]; vstr s0, [sp, #-8]; vldr d1, [sp]", 2 + 2 + 3, 3),
    "fpu_registers": ("vmov s0, r0; vmov r1, r2, s0, s1; vcmp.f32 s0, s1; vmrs apsr_nzcv, fpscr",
                      1 + 2 + 1 + 1, 4),
    "fpu_stack": ("vpush {d8-d9}; vpop {d8-d9}", 2 * (1 + 4), 2),
}


def assembly():
    lines = [".syntax unified", ".cpu cortex-m4", ".fpu fpv4-sp-d16", ".thumb"]

    def function(name, body):
        lines.extend([f".section .text.bench_{name}, \"ax\"", f".global {name}",
                      f".type {name}, %function", f"{name}:", *body.split(";"), "bx lr",
                      f".size {name}, . - {name}", ".ltorg"])

    for name, (body, _, _) in SEQUENCES.items():
        function(name, body)
    function("inner", "1: subs r0, r0, #1; bpl 1b")
    function("outer", "push {r3, lr}; bl inner; pop {r3, lr}")
    return "\n".join(lines) + "\n"


def problems(image):
    for name, (_, cycles, instructions) in SEQUENCES.items():
        found = count.measure(count.start(image), name, calls=2, warm=0)
        expected = {"cycles": cycles + RETURN, "instructions": instructions + 1}
        for what, value in expected.items():
            if (found[what]["min"], found[what]["max"]) != (value, value):
                yield f"{name}: {what} {found[what]}, expected {value}"
    inner = count.measure(count.start(image), "outer", target="inner", calls=3, warm=1)
    # Calls 1 to 3 go round 2 to 4 times: subs and a taken bpl, in the end one that is not taken.
    for what, expected in (("instructions", (2 * 2 + 1, 2 * 4 + 1)),
                           ("cycles", (2 + 3 + 1 + RETURN, 4 + 3 * 3 + 1 + RETURN))):
        if (inner[what]["min"], inner[what]["max"]) != expected:
            yield f"inner in outer: {what} {inner[what]}, expected {expected}"
    stack = count.measure(count.start(image), "stack", calls=1, warm=0)
    if (stack["stack"], stack["stores"]["max"], stack["ram"]) != (20, 5, 0):
        yield f"stack: {stack}, expected 20 bytes of stack, 5 stores and no other RAM"


def main():
    if build.missing():
        print(f"skipped: {build.missing()}")
        return 77
    with tempfile.TemporaryDirectory() as folder:
        source = pathlib.Path(folder) / "sequences.s"
        source.write_text(assembly())
        elf = source.with_suffix(".elf")
        build.run(build.GCC, *build.CORES["m4f"], source, "-nostdlib", "-T", build.HERE / "image.ld",
                  "-o", elf)
        found = list(problems(Image(elf)))
    for text in found:
        print(text)
    print(f"{len(SEQUENCES) + 2} sequences, {len(found)} wrong")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
