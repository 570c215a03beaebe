#include "rp2350_fake.h"

#include <string.h>

#include "chip.h"

#define ENTRIES_MAX 65536
#define REGISTERS 512
#define TEXT_MAX 4096
#define WORDS 8
#define WORD_AT 0x20000000u
#define PAD_ISOLATED 0x116u
#define PINS 30u

typedef struct {
    uint32_t address, value;
} entry_t;

static struct {
    entry_t entries[ENTRIES_MAX];
    int count;
    entry_t registers[REGISTERS];
    int used;
    const uint32_t *words[WORDS]; // that the DMA reads
    int word_count;
    uint32_t input[4];
    uint32_t fifo[ADC_FIFO_DEPTH];
    uint32_t level;
    bool running; // a conversion
    bool crystal_dead, fault, driver_latched;
    char text[TEXT_MAX];
    size_t text_length;
} fake;

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

void fake_reset(void) {
    memset(&fake, 0, sizeof fake);
    fake_put(RESETS_RESET, 0x1FFFFFFFu);
    fake_put(CLK_SYS_CTRL, 0x41u); // from the ring oscillator as the auxiliary source
    fake_put(CLK_SYS_SELECTED, 2u);
    fake_put(TIMER0_DBGPAUSE, 7u);
    for (uint32_t n = 0u; n < PINS; n++) {
        fake_put(PAD(n), PAD_ISOLATED);
        fake_put(PIN_CTRL(n), 31u);
    }
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

// --- pins and driver ---

static bool pin_is_high(uint32_t gpio) {
    return fake_get(PAD(gpio)) == PAD_OUTPUT && fake_get(PIN_CTRL(gpio)) == PIN_SIO &&
           (fake_get(GPIO_OUT) & fake_get(GPIO_OE_SET) & 1u << gpio) != 0u;
}

static void model_driver(void) {
    const uint32_t line = 1u << VARIANT_FAULT_GPIO;
    const bool was_low = (fake_get(GPIO_IN) & line) == 0u;
    if (!pin_is_high(VARIANT_RESET_GPIO)) {
        fake.driver_latched = false;
    }
    fake.driver_latched = fake.driver_latched || fake.fault;
    const bool pulled = fake_get(PAD(VARIANT_FAULT_GPIO)) == PAD_INPUT_PULLED_UP;
    const bool low = fake.driver_latched || !pulled;
    *reg(GPIO_IN) = low ? fake_get(GPIO_IN) & ~line : fake_get(GPIO_IN) | line;
    if (low && !was_low) {
        *reg(PIN_EVENTS(VARIANT_FAULT_GPIO)) |= PIN_EVENT_FELL(VARIANT_FAULT_GPIO);
    }
}

void fake_set_fault(bool active) {
    fake.fault = active;
    model_driver();
}

bool fake_gates_on(void) {
    return pin_is_high(VARIANT_ENABLE_GPIO) && pin_is_high(VARIANT_RESET_GPIO) &&
           !fake.driver_latched;
}

bool fake_is_pwm(uint32_t gpio) {
    return fake_get(PAD(gpio)) == PAD_OUTPUT && fake_get(PIN_CTRL(gpio)) == PIN_PWM;
}

// --- ADC and DMA ---

void fake_set_input(uint32_t n, uint32_t count) {
    fake.input[n] = count;
}

static void convert(void) {
    const uint32_t control = fake_get(ADC_CS);
    const uint32_t at = control >> ADC_CS_FIRST_Pos & 15u;
    const uint32_t round = control >> ADC_CS_ROUND_Pos & 15u;
    if ((fake_get(ADC_FCS) & ADC_FCS_EN) != 0u) {
        if (fake.level < ADC_FIFO_DEPTH) {
            fake.fifo[fake.level++] = fake.input[at & 3u];
        } else {
            *reg(ADC_FCS) |= ADC_FCS_OVER;
        }
    }
    uint32_t next = (at + 1u) % 4u;
    while (round != 0u && (round & 1u << next) == 0u) {
        next = (next + 1u) % 4u;
    }
    *reg(ADC_CS) = (control & ~(15u << ADC_CS_FIRST_Pos)) | next << ADC_CS_FIRST_Pos;
}

// The word of a channel that this slice paces goes where the channel writes.
static bool wrap(uint32_t slice) {
    bool moved = false;
    for (uint32_t n = 0u; n < 2u; n++) {
        const uint32_t word = (fake_get(DMA_READ(n)) - WORD_AT) / 4u;
        if (fake_get(DMA_CTRL(n)) == DMA_WORD_PER_WRAP(n, slice) &&
            fake_get(DMA_COUNT(n)) == DMA_COUNT_ENDLESS && word < (uint32_t)fake.word_count &&
            (fake_get(PWM_EN) & 1u << slice) != 0u) {
            *reg(fake_get(DMA_WRITE(n))) = *fake.words[word];
            moved = true;
        }
    }
    return moved;
}

bool fake_trigger(void) {
    if (fake.running &&
        (fake_get(ADC_CS) & ADC_CS_START_MANY) == 0u) { // that nobody has waited for
        convert();
        fake.running = false;
    }
    if (!wrap(CHIP_TRIGGER_SLICE) || (fake_get(ADC_CS) & ADC_CS_START_MANY) == 0u) {
        return false;
    }
    const uint32_t threshold = fake_get(ADC_FCS) >> ADC_FCS_THRESHOLD_Pos & 15u;
    for (uint32_t n = 0u; n < 16u && fake.level < threshold; n++) {
        convert();
    }
    fake.running = true; // the next one has begun
    return fake.level >= threshold && (fake_get(ADC_INTE) & ADC_INTE_FIFO) != 0u;
}

void fake_halt(uint32_t cycles) {
    const uint32_t top = fake_get(PWM_TOP(CHIP_DEADLINE_SLICE));
    const uint32_t at = fake_get(PWM_CTR(CHIP_DEADLINE_SLICE)) + cycles;
    if (at > top) {
        (void)wrap(CHIP_DEADLINE_SLICE);
    }
    fake_put(PWM_CTR(CHIP_DEADLINE_SLICE), at % (top + 1u));
    if (fake_get(TIMER0_DBGPAUSE) == 0u) {
        *reg(TIMER0_RAWL) += cycles;
    }
    for (uint32_t n = 0u; n < cycles / 300u && (fake_get(ADC_CS) & ADC_CS_START_MANY) != 0u; n++) {
        convert();
    }
}

// --- accesses ---

void fake_kill_crystal(void) {
    fake.crystal_dead = true;
}

static void model_clock(void) {
    const bool crystal = fake_get(XOSC_CTRL) == XOSC_ENABLE_1_15_MHZ && !fake.crystal_dead;
    fake_put(RESETS_DONE, ~fake_get(RESETS_RESET) & 0x1FFFFFFFu);
    fake_put(XOSC_STATUS, crystal ? XOSC_STABLE : 0u);
    fake_put(CLK_REF_SELECTED, 1u << (fake_get(CLK_REF_CTRL) & 3u));
    fake_put(CLK_SYS_SELECTED, 1u << (fake_get(CLK_SYS_CTRL) & 1u));
    const uint32_t plls[] = {PLL_SYS, PLL_USB}, resets[] = {RESET_PLL_SYS, RESET_PLL_USB};
    for (int n = 0; n < 2; n++) {
        const bool on = crystal && (fake_get(RESETS_DONE) & resets[n]) != 0u &&
                        (fake_get(plls[n] + PLL_PWR) & 0x21u) == 0u;
        *reg(plls[n] + PLL_CS) = PLL_CS_REFDIV_1 | (on ? PLL_CS_LOCK : 0u);
    }
    if ((fake_get(ADC_CS) & ADC_CS_EN) != 0u && !fake.running) {
        *reg(ADC_CS) |= ADC_CS_READY;
    }
}

static bool is_sticky(uint32_t address) {
    return address == PIN_EVENTS(VARIANT_FAULT_GPIO) || address == PLL_SYS + PLL_INTR;
}

uint32_t reg_read(uint32_t address) {
    if (address == ADC_FIFO) {
        const uint32_t first = fake.level > 0u ? fake.fifo[0] : 0u;
        if (fake.level > 0u) {
            fake.level--;
            memmove(&fake.fifo[0], &fake.fifo[1], sizeof fake.fifo - sizeof fake.fifo[0]);
        } else {
            *reg(ADC_FCS) |= ADC_FCS_UNDER;
        }
        return first;
    }
    if (address == ADC_FCS) {
        return (fake_get(ADC_FCS) & ~ADC_FCS_EMPTY) | fake.level << 16 |
               (fake.level == 0u ? ADC_FCS_EMPTY : 0u);
    }
    if (address == ADC_CS && fake.running) { // one look is as long as a conversion
        const uint32_t busy = fake_get(ADC_CS) & ~ADC_CS_READY;
        convert();
        fake.running = (busy & ADC_CS_START_MANY) != 0u;
        *reg(ADC_CS) |= ADC_CS_READY;
        return busy;
    }
    return fake_get(address);
}

void reg_write(uint32_t address, uint32_t value) {
    if (fake.count < ENTRIES_MAX) {
        fake.entries[fake.count++] = (entry_t){address, value};
    }
    if (is_sticky(address)) {
        *reg(address) &= ~value;
    } else if (address == GPIO_OUT_SET) {
        *reg(GPIO_OUT) |= value;
    } else if (address == GPIO_OUT_CLR) {
        *reg(GPIO_OUT) &= ~value;
    } else if (address == ADC_FCS) { // two flags by writing 1
        *reg(ADC_FCS) = value & ~(ADC_FCS_OVER | ADC_FCS_UNDER);
    } else {
        *reg(address) = value;
    }
    if (address == UART0_DR && fake.text_length + 1 < TEXT_MAX) {
        fake.text[fake.text_length++] = (char)value;
    }
    model_clock();
    model_driver();
}

uint32_t reg_address_of(const uint32_t *word) {
    for (int n = 0; n < fake.word_count; n++) {
        if (fake.words[n] == word) {
            return WORD_AT + 4u * (uint32_t)n;
        }
    }
    fake.words[fake.word_count] = word;
    return WORD_AT + 4u * (uint32_t)fake.word_count++;
}

const char *fake_serial_text(void) {
    return fake.text;
}
