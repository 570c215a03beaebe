/* Memories and sections of an F28004x for this port, flash boot, EABI. Lengths are words of 16 bits.
   TI's generic file gives .bss, and what runs from RAM, one block of 0x800 words each: too little for
   the drive's step and the recorders. Blocks that lie side by side are one range here.
   The ends of M1, GS3 and bank 1 stay free: the core fetches ahead beyond valid memory (TI's errata). */
--stack_size=0x600

MEMORY
{
   BEGIN      : origin = 0x080000, length = 0x000002 /* boot to flash */
   FLASH0     : origin = 0x080002, length = 0x00FFFE /* bank 0 */
   FLASH1     : origin = 0x090000, length = 0x00FFF0 /* bank 1 */
   RESET      : origin = 0x3FFFC0, length = 0x000002

   RAMM       : origin = 0x0000F6, length = 0x000702 /* M0 behind the boot ROM's stack, and M1 */
   RAMLS      : origin = 0x008000, length = 0x004000 /* LS0 .. LS7 */
   RAMGS01    : origin = 0x00C000, length = 0x004000 /* GS0, GS1 */
   RAMGS2     : origin = 0x010000, length = 0x002000
   RAMGS3     : origin = 0x012000, length = 0x001FF8
}

SECTIONS
{
   codestart   : > BEGIN
   .reset      : > RESET, TYPE = DSECT
   .text       : >> FLASH0 | FLASH1, ALIGN(8) /* functions stay whole */
   .cinit      : > FLASH1, ALIGN(8)
   .const      : > FLASH1, ALIGN(8)
   .switch     : > FLASH1, ALIGN(8)
   .init_array : > FLASH1, ALIGN(8)

   .stack      : > RAMM
   .bss        : > RAMGS01
   .data       : > RAMGS01
   .sysmem     : > RAMGS3
   .TI.noinit  : > RAMGS2 /* outlives a reset by the watchdog */

   .TI.ramfunc : LOAD = FLASH0, RUN = RAMLS,
                 LOAD_START(RamfuncsLoadStart), LOAD_SIZE(RamfuncsLoadSize),
                 LOAD_END(RamfuncsLoadEnd), RUN_START(RamfuncsRunStart),
                 RUN_SIZE(RamfuncsRunSize), RUN_END(RamfuncsRunEnd), ALIGN(8)
}
