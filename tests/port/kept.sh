# Sourced by the scripts that build images.
# kept ELF: what outlives a reset, the variables of port/example/kept.c, lies where start-up code neither
# clears nor copies. Only data count: functions of the core may have the same names. The x keeps awk from
# reading an address such as 200030e4 as a number with an exponent.
kept() {
    arm-none-eabi-nm "$1" | awk '
        ($3 == "bss_end" || $3 == "data_end") && "x" $1 > end { end = "x" $1 }
        $2 ~ /^[bd]$/ && $3 ~ /^(resets|check|kept_armed|attempts)$/ { at[++n] = "x" $1 }
        END { for (i in at) if (at[i] < end) n = 0
              exit !(n == 4 && end) }' ||
        { echo "$1: the counts of resets and new starts: expected behind .bss"; exit 1; }
}
