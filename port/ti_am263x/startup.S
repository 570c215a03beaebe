// From the boot loader's jump to main(): modes and stacks, FPU, memory protection, cycle counter.
// Needs nothing of the vendor's. Exceptions that nobody expects switch the gates off and wait for the
// watchdog.
    .syntax unified
    .arm
    .fpu vfpv3-d16

    .equ MODE_IRQ, 0x12
    .equ MODE_ABORT, 0x17
    .equ MODE_UNDEFINED, 0x1B
    .equ MODE_SYSTEM, 0x1F
    .equ NO_INTERRUPTS, 0xC0

    .section .vectors, "ax", %progbits
    .global vectors
vectors:
    ldr pc, =reset_handler
    ldr pc, =stop_handler       // undefined instruction
    ldr pc, =stop_handler       // supervisor call
    ldr pc, =stop_handler       // prefetch abort
    ldr pc, =stop_handler       // data abort
    ldr pc, =stop_handler
    ldr pc, =irq_entry
    ldr pc, =stop_handler       // FIQ
    .ltorg

    .section .text.irq_entry, "ax", %progbits
    .global irq_entry
    .type irq_entry, %function
irq_entry:                      // on the system mode's stack, so that one stack serves all
    sub lr, lr, #4
    srsdb sp!, #MODE_SYSTEM
    cps #MODE_SYSTEM
    push {r0-r3, r12, lr}
    vpush {d0-d7}
    vmrs r0, fpscr
    and r1, sp, #4              // the interrupted code may stand on half of eight
    sub sp, sp, r1
    push {r0, r1}
    bl irq_handler
    pop {r0, r1}
    add sp, sp, r1
    vmsr fpscr, r0
    vpop {d0-d7}
    pop {r0-r3, r12, lr}
    rfeia sp!

    .section .text.stop_handler, "ax", %progbits
    .type stop_handler, %function
stop_handler:                   // from any mode, with a stack of its own
    cpsid if, #MODE_SYSTEM
    ldr sp, =stack_end
    bl board_gates_off
1:  b 1b

    .macro region number, base, size, access
    mov r0, #\number
    mcr p15, 0, r0, c6, c2, 0   // region
    ldr r0, =\base
    mcr p15, 0, r0, c6, c1, 0   // base
    ldr r0, =\access
    mcr p15, 0, r0, c6, c1, 4   // access and kind
    ldr r0, =(\size << 1) | 1
    mcr p15, 0, r0, c6, c1, 2   // size 2^(size + 1), on
    .endm

    .section .text.reset_handler, "ax", %progbits
    .global reset_handler
    .type reset_handler, %function
reset_handler:
    cpsid if, #MODE_SYSTEM
    ldr sp, =stack_end

    mrc p15, 0, r0, c1, c0, 0   // MPU off, low vectors, branch prediction on
    bic r0, r0, #0x2000
    bic r0, r0, #1
    orr r0, r0, #0x800
    mcr p15, 0, r0, c1, c0, 0
    isb

    // A later region wins. Registers must not be cached nor executed; the core's default would.
    region 0, 0x00000000, 31, 0x1300    // 4 GB: strongly ordered, no code
    region 1, 0x00000000, 19, 0x030C    // 1 MB, both TCM: normal, not cached
    region 2, 0x70000000, 20, 0x030B    // 2 MB, on-chip RAM: normal, write-back
    dsb
    mov r1, #0
    mcr p15, 0, r1, c15, c5, 0  // caches empty
    mcr p15, 0, r1, c7, c5, 0
    mrc p15, 0, r0, c1, c0, 0
    orr r0, r0, #0x1000         // instruction cache
    orr r0, r0, #0x0005         // data cache, MPU
    dsb
    mcr p15, 0, r0, c1, c0, 0
    isb

    mrc p15, 0, r0, c1, c0, 2   // FPU
    orr r0, r0, #0xF00000
    mcr p15, 0, r0, c1, c0, 2
    isb
    mov r0, #0x40000000
    vmsr fpexc, r0

    mov r0, #5                  // cycle counter from 0, on
    mcr p15, 0, r0, c9, c12, 0
    mov r0, #0x80000000
    mcr p15, 0, r0, c9, c12, 1

    ldr r0, =bss_begin
    ldr r1, =bss_end
    mov r2, #0
1:  cmp r0, r1
    strlo r2, [r0], #4
    blo 1b

    bl main
    b stop_handler
