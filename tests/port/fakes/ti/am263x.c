#include "am263x.h"

#include <string.h>

#include "am263x_fake.h"
#include "reg.h"

#define ENTRIES_MAX 65536
#define REGISTERS 512
#define PHASES 3
#define TEXT_MAX 4096
#define NO_CURRENT_COUNT 1986u // of the comparators' DACs: 1.6 V of 3.3 V

typedef struct {
    uint32_t address, value;
} entry_t;

static struct {
    entry_t entries[ENTRIES_MAX];
    int count;
    entry_t registers[REGISTERS];
    int used;
    uint32_t comparators, dead_comparator;
    bool dead_high; // of the two in it, the one for positive currents
    bool fault, gated, halted, clock_lost;
    uint32_t cycles, step;
    int interrupts_on;
    char text[TEXT_MAX];
    size_t text_length;
} fake;

void fake_reset(void) {
    memset(&fake, 0, sizeof fake);
    fake.interrupts_on = -1;
    fake.step = 400u;
    fake.dead_comparator = ~0u;
    for (int n = 0; n < PHASES; n++) {
        fake_put(EPWM(n) + EPWM_TBSTS, TBSTS_UP);
    }
}

static uint32_t *reg(uint32_t address) {
    int n = 0;
    while (n < fake.used && fake.registers[n].address != address) {
        n++;
    }
    if (n == fake.used && fake.used < REGISTERS - 1) {
        fake.registers[fake.used++].address = address;
    }
    return &fake.registers[n].value;
}

uint32_t fake_get(uint32_t address) {
    return *reg(address);
}

void fake_put(uint32_t address, uint32_t value) {
    *reg(address) = value;
}

int fake_count(void) {
    return fake.count;
}

int fake_first(uint32_t address, uint32_t mask, uint32_t bits, int from) {
    for (int n = from; n >= 0 && n < fake.count; n++) {
        if (fake.entries[n].address == address && (fake.entries[n].value & mask) == bits) {
            return n;
        }
    }
    return -1;
}

// --- trip zones ---

static bool compared(void) {
    for (uint32_t n = 0u; n < 10u; n++) {
        const uint32_t control = COMPCTL_ON | COMPCTL_HIGH_FILTERED | COMPCTL_LOW_FILTERED_INVERTED;
        const uint32_t high = fake_get(CMPSSB(n) + CMPSS_DACHVALS);
        const uint32_t low = fake_get(CMPSSB(n) + CMPSS_DACLVALS);
        const bool dead = n == fake.dead_comparator;
        const bool beyond = (high < NO_CURRENT_COUNT && !(dead && fake.dead_high)) ||
                            (low > NO_CURRENT_COUNT && !(dead && !fake.dead_high));
        if ((beyond || (fake.comparators & 1u << n) != 0u) &&
            fake_get(CMPSSB(n) + CMPSS_COMPCTL) == control &&
            (fake_get(CMPSSB(n) + CMPSS_HFILCTL) & FILCTL_INIT) != 0u &&
            (fake_get(PWMXBAR0_G1) & PWMXBAR_CMPSSB(n)) == PWMXBAR_CMPSSB(n)) {
            return true;
        }
    }
    return false;
}

static void sources_act(void) {
    const bool fault =
        fake.fault && fake_get(INPUTXBAR0_G0) == 50u && fake_get(PWMXBAR1_G4) == PWMXBAR_INPUT0;
    for (int n = 0; n < PHASES; n++) {
        const uint32_t base = EPWM(n);
        const uint32_t condition = fake_get(base + EPWM_TZDCSEL);
        const uint32_t enabled = fake_get(base + EPWM_TZSEL);
        if (fake_get(base + EPWM_DCTRIPSEL) != DCTRIPSEL_AH_1_BH_2) {
            continue;
        }
        if (compared() && (condition & 7u) == TZDCSEL_A1_HIGH && (enabled & TZ_DCAEVT1) != 0u) {
            *reg(base + EPWM_TZOSTFLG) |= TZOST_DCAEVT1;
            *reg(base + EPWM_TZFLG) |= TZFLG_OST | TZFLG_DCAEVT1;
        }
        if (fake.halted && (fake_get(CONTROLSS_EPWM_HALTEN(n)) & HALTEN_R5SS0_CORE0) != 0u &&
            (enabled & TZ_OST6) != 0u) {
            *reg(base + EPWM_TZOSTFLG) |= TZOST_OST6;
            *reg(base + EPWM_TZFLG) |= TZFLG_OST;
        }
        if (fake.clock_lost && (enabled & TZ_OST5) != 0u) {
            *reg(base + EPWM_TZOSTFLG) |= TZOST_OST5;
            *reg(base + EPWM_TZFLG) |= TZFLG_OST;
        }
        if (fault && (condition & 0x1C0u) == TZDCSEL_B1_LOW && (enabled & TZ_DCBEVT1) != 0u) {
            *reg(base + EPWM_TZOSTFLG) |= TZOST_DCBEVT1;
            *reg(base + EPWM_TZFLG) |= TZFLG_OST | TZFLG_DCBEVT1;
        }
    }
}

void fake_set_comparator(uint32_t n, bool active) {
    fake.comparators = active ? fake.comparators | 1u << n : fake.comparators & ~(1u << n);
    sources_act();
}

void fake_kill_comparator(uint32_t n, bool high) {
    fake.dead_comparator = n;
    fake.dead_high = high;
}

void fake_set_fault(bool active) {
    fake.fault = active;
    sources_act();
}

void fake_set_halted(bool halted) {
    fake.halted = halted;
    sources_act();
}

void fake_set_clock_lost(bool lost) {
    fake.clock_lost = lost;
    sources_act();
}

bool fake_gates_on(void) {
    bool on = true;
    for (uint32_t pad = 43u; pad <= 48u; pad++) {
        on = on && fake_get(IOMUX_PAD(pad)) == PAD_OUTPUT;
    }
    for (int n = 0; n < PHASES; n++) {
        on = on && (fake_get(EPWM(n) + EPWM_TZFLG) & TZFLG_OST) == 0u;
    }
    return on;
}

bool fake_all_tripped(void) {
    uint32_t all = TZFLG_OST;
    for (int n = 0; n < PHASES; n++) {
        all &= fake_get(EPWM(n) + EPWM_TZFLG);
    }
    return all != 0u;
}

static bool model_trip_zone(uint32_t address, uint32_t value) {
    for (int n = 0; n < PHASES; n++) {
        const uint32_t base = EPWM(n);
        if (address == base + EPWM_TZFRC) {
            *reg(base + EPWM_TZFLG) |= value;
        } else if (address == base + EPWM_TZCLR) {
            *reg(base + EPWM_TZFLG) &= ~value;
        } else if (address == base + EPWM_TZOSTCLR) {
            *reg(base + EPWM_TZOSTFLG) &= ~value;
        } else {
            continue;
        }
        return true;
    }
    return false;
}

// --- accesses ---

void fake_gate_clock(void) {
    fake.gated = true;
}

static void note(uint32_t address, uint32_t value) {
    if (fake.count < ENTRIES_MAX) {
        fake.entries[fake.count++] = (entry_t){address, value};
    }
    if (fake.gated && address >= EPWM(0) && address < EPWM(32)) {
        return;
    }
    const bool locked =
        fake_get(CONTROLSS_KICK0) != KICK0_UNLOCK || fake_get(CONTROLSS_KICK1) != KICK1_UNLOCK;
    if (locked && address >= CONTROLSS_CLKSYNC && address < CONTROLSS_KICK0) {
        return;
    }
    if (address == TOP_RCM_WARM_RST_CAUSE_CLR && value == RST_CAUSE_FORGET &&
        fake_get(TOP_RCM_KICK0) == KICK0_UNLOCK && fake_get(TOP_RCM_KICK1) == KICK1_UNLOCK) {
        *reg(TOP_RCM_WARM_RST_CAUSE) = 0u;
    }
    if (address == ADC(0) + ADC_INTOVFCLR) {
        *reg(ADC(0) + ADC_INTOVF) &= ~value;
    } else if (!model_trip_zone(address, value)) {
        *reg(address) = value;
    }
    if (address == UART0 + UART_THR && fake.text_length + 1 < TEXT_MAX) {
        fake.text[fake.text_length++] = (char)value;
    }
    sources_act();
}

uint16_t reg_read16(uint32_t address) {
    return (uint16_t)fake_get(address);
}

uint32_t reg_read32(uint32_t address) {
    return fake_get(address);
}

void reg_write16(uint32_t address, uint32_t value) {
    note(address, value & 0xFFFFu);
}

void reg_write32(uint32_t address, uint32_t value) {
    note(address, value);
}

void fake_set_cycles(uint32_t cycles, uint32_t step) {
    fake.cycles = cycles;
    fake.step = step;
}

uint32_t reg_cycles(void) {
    fake.cycles += fake.step;
    return fake.cycles;
}

void reg_interrupts_on(void) {
    fake.interrupts_on = fake.count;
}

int fake_interrupts_on(void) {
    return fake.interrupts_on;
}

const char *fake_serial_text(void) {
    return fake.text;
}
