// Telemetry ring: frames on the wire, and an interrupt that comes between any two steps of the thread.
#define _GNU_SOURCE // for the registers of a signal's context
#include <signal.h>
#include <stdlib.h>
#include <sys/time.h>
#include <ucontext.h>

// The ring with an interrupt in place of each of its compiler barriers, which stand where it could hurt.
static void interrupted(void);
#define LODE_SIGNAL_FENCE() interrupted()
#include "../src/ring.c"

#include "support/source.h"

enum { CHANNELS = 3, DATA_OCTETS = 4 * (CHANNELS + 2), DESCRIPTION_OCTETS = 4 * (CHANNELS + 6) };

static source_t source;
static lode_ring_t ring;
static uint32_t buffer[LODE_RING_WORDS(CHANNELS, 7)];

static void period(void) {
    source_step(&source);
    lode_ring_step(&ring, &source.drive);
}

// ---- Interrupts at barriers ---------------------------------------------------------------------

static bool in_interrupt;
static uint32_t barriers;       // passed by the thread
static uint32_t interrupt_from; // from this one on
static uint32_t interrupts;     // so many of them, at each barrier

static void interrupted(void) {
    if (in_interrupt || barriers++ < interrupt_from) {
        return;
    }
    in_interrupt = true;
    for (uint32_t n = 0; n < interrupts; n++) {
        period();
    }
    in_interrupt = false;
}

void setUp(void) {
    source_init(&source);
    in_interrupt = false;
    barriers = 0u;
    interrupts = 0u;
    interrupt_from = 0u;
}

void tearDown(void) {}

static void start(uint32_t slots, uint16_t decimation) {
    const lode_channels_config_t config = source_channels(decimation);
    TEST_ASSERT_EQUAL_INT(LODE_OK,
                          lode_ring_init(&ring, &config, buffer, LODE_RING_WORDS(CHANNELS, slots)));
}

// ---- A receiver of its own ----------------------------------------------------------------------

typedef struct {
    uint16_t octet[DESCRIPTION_OCTETS];
    uint32_t octets;
    uint32_t frames; // of data
    uint32_t descriptions;
    uint32_t lost;     // by the sequence numbers
    uint32_t next;     // sequence number expected
    uint32_t overruns; // told by the last description
    uint16_t decimation;
} receiver_t;

static uint32_t word_at(const receiver_t *self, uint32_t n) {
    const uint16_t *o = &self->octet[4u * n];
    return o[0] | (uint32_t)o[1] << 8 | (uint32_t)o[2] << 16 | (uint32_t)o[3] << 24;
}

static void check_crc(const receiver_t *self, uint32_t words) {
    uint32_t crc = 0xFFFFFFFFu;
    for (uint32_t n = 0; n < 32u * (words - 1u); n++) {
        const uint32_t bit = (uint32_t)self->octet[n / 8u] >> (n % 8u) & 1u;
        crc = (crc >> 1) ^ (((crc ^ bit) & 1u) != 0u ? 0xEDB88320u : 0u);
    }
    TEST_ASSERT_EQUAL_HEX32(~crc, word_at(self, words - 1u));
}

static void take_description(receiver_t *self) {
    TEST_ASSERT_EQUAL_FLOAT(SOURCE_F_PWM_Hz, check_from_bits(word_at(self, 1)));
    TEST_ASSERT_EQUAL_UINT32(self->decimation, word_at(self, 2));
    TEST_ASSERT_EQUAL_HEX32(word_at(self, 3) & 0xFFFFu, word_at(self, 0) >> 16);
    const uint32_t next = word_at(self, 3);
    TEST_ASSERT_TRUE(self->frames % LODE_RING_DESCRIBE_EVERY == 0u);
    self->lost += next - self->next;
    self->next = next;
    self->overruns = word_at(self, 4);
    TEST_ASSERT_EQUAL_UINT32(LODE_CHANNEL_TEMPERATURE, word_at(self, 5));
    TEST_ASSERT_EQUAL_UINT32(LODE_CHANNEL_V_BUS, word_at(self, 6));
    TEST_ASSERT_EQUAL_UINT32(LODE_CHANNEL_MODE, word_at(self, 7));
    self->descriptions++;
}

static void take_data(receiver_t *self) {
    TEST_ASSERT_TRUE(self->descriptions > 0u); // first comes what it means
    const uint32_t gap = ((word_at(self, 0) >> 16) - self->next) & 0xFFFFu;
    self->lost += gap;
    self->next += gap;
    const uint32_t row[CHANNELS] = {word_at(self, 1), word_at(self, 2), word_at(self, 3)};
    source_check_row(row, self->next * self->decimation);
    self->next++;
    self->frames++;
}

static void receive(receiver_t *self, const uint16_t *octets, uint32_t count) {
    for (uint32_t n = 0; n < count; n++) {
        TEST_ASSERT_TRUE(octets[n] <= 0xFFu);
        self->octet[self->octets++] = octets[n];
        if (self->octets == 2u) {
            TEST_ASSERT_EQUAL_HEX16(0xA5u, self->octet[0]);
            TEST_ASSERT_TRUE(self->octet[1] == (0x20u | CHANNELS) ||
                             self->octet[1] == (0xA0u | (CHANNELS + 4u)));
        }
        const uint32_t payload = self->octets < 2u ? 31u : self->octet[1] & 31u;
        if (self->octets == 4u * (payload + 2u)) {
            check_crc(self, payload + 2u);
            if ((self->octet[1] & 0x80u) != 0u) {
                take_description(self);
            } else {
                take_data(self);
            }
            self->octets = 0u;
        }
    }
}

/// Drains in pieces of `piece` octets until nothing is left.
static void drain(receiver_t *self, uint32_t piece) {
    uint16_t octets[100];
    for (uint32_t got = 1u; got > 0u;) {
        got = lode_ring_drain(&ring, octets, piece);
        TEST_ASSERT_TRUE(got <= piece);
        receive(self, octets, got);
    }
}

// ---- Tests --------------------------------------------------------------------------------------

static void test_frames_arrive_in_order_whatever_the_pieces(void) {
    for (uint32_t piece = 1; piece <= 100u; piece += piece < 45u ? 1u : 11u) {
        source_init(&source);
        start(7, 1);
        receiver_t receiver = {.decimation = 1};
        for (int n = 0; n < 300; n++) {
            period();
            if (n % 5 == 0) {
                drain(&receiver, piece);
            }
        }
        drain(&receiver, piece);
        TEST_ASSERT_EQUAL_UINT32(300u, receiver.frames);
        TEST_ASSERT_EQUAL_UINT32(0u, receiver.lost);
        TEST_ASSERT_EQUAL_UINT32(5u, receiver.descriptions); // before 0, 64, 128, 192, 256
        TEST_ASSERT_EQUAL_UINT32(0u, receiver.octets);
    }
}

static void test_decimation(void) {
    start(7, 10);
    receiver_t receiver = {.decimation = 10};
    for (int n = 0; n < 1000; n++) {
        period();
        drain(&receiver, 30u);
        TEST_ASSERT_EQUAL_UINT32((uint32_t)n / 10u + 1u, receiver.frames);
    }
}

static void test_a_full_ring_leaves_out_and_counts(void) {
    start(7, 1);
    receiver_t receiver = {.decimation = 1};
    for (int n = 0; n < 50; n++) {
        period();
    }
    TEST_ASSERT_EQUAL_UINT32(43u, lode_ring_overruns(&ring));
    drain(&receiver, 9u);
    TEST_ASSERT_EQUAL_UINT32(7u, receiver.frames); // the oldest
    TEST_ASSERT_EQUAL_UINT32(0u, receiver.lost);
    period();
    drain(&receiver, 9u);
    TEST_ASSERT_EQUAL_UINT32(43u, receiver.lost);
    TEST_ASSERT_EQUAL_UINT32(8u, receiver.frames);
    TEST_ASSERT_EQUAL_UINT32(43u, buffer[LODE_RING_AT_OVERRUNS]);
    TEST_ASSERT_EQUAL_UINT32(8u, buffer[LODE_RING_AT_WRITTEN]);
}

static void test_a_description_tells_overruns_and_long_gaps(void) {
    start(7, 1);
    receiver_t receiver = {.decimation = 1};
    for (int n = 0; n < 70000; n++) { // more than the 16 bits of a data frame tell
        period();
    }
    for (int n = 0; n < 100; n++) {
        drain(&receiver, 100u);
        period();
    }
    TEST_ASSERT_EQUAL_UINT32(70000u - 7u, receiver.overruns);
    TEST_ASSERT_EQUAL_UINT32(2u, receiver.descriptions);
    // The first description came before the gap; the second one sets the count right.
    TEST_ASSERT_EQUAL_UINT32(70099u, receiver.next);
    TEST_ASSERT_EQUAL_UINT32(70000u - 7u, receiver.lost);
}

static void test_buffer_is_described_for_a_debugger(void) {
    start(7, 4);
    for (int n = 0; n < 9; n++) {
        period();
    }
    const uint32_t header[] = {0x69526F4Cu, 1u, 3u, 7u, 0x459C4000u, 4u, 3u, 0u, 12u, 11u, 0u};
    TEST_ASSERT_EQUAL_HEX32_ARRAY(header, buffer, COUNT_OF(header));
    for (uint32_t n = 0; n < 3u; n++) {
        const uint32_t *slot = &buffer[COUNT_OF(header) + 4u * n];
        TEST_ASSERT_EQUAL_UINT32(n, slot[0]);
        source_check_row(&slot[1], 4u * n);
    }
}

static void test_nothing_behind_the_buffer_is_touched(void) {
    for (uint32_t spare = 0; spare < 4u; spare++) {
        const uint32_t words = LODE_RING_WORDS(CHANNELS, 2) + spare;
        memset(buffer, 0x5A, sizeof buffer);
        const lode_channels_config_t config = source_channels(1);
        TEST_ASSERT_EQUAL_INT(LODE_OK, lode_ring_init(&ring, &config, buffer, words));
        receiver_t receiver = {.decimation = 1};
        source_init(&source);
        for (int n = 0; n < 20; n++) {
            period();
            drain(&receiver, 7u);
        }
        TEST_ASSERT_EQUAL_UINT32(20u, receiver.frames);
        for (uint32_t n = LODE_RING_WORDS(CHANNELS, 2); n < LODE_RING_WORDS(CHANNELS, 7); n++) {
            TEST_ASSERT_EQUAL_HEX32(0x5A5A5A5Au, buffer[n]);
        }
    }
}

static void test_bad_configurations_are_refused(void) {
    lode_channels_config_t config = source_channels(1);
    const uint32_t least = LODE_RING_WORDS(CHANNELS, 2);
    memset(buffer, 0x5A, sizeof buffer);
    lode_ring_t before;
    memset(&before, 0x33, sizeof before);
    ring = before;
    TEST_ASSERT_EQUAL_INT(LODE_ERROR_NULL, lode_ring_init(NULL, &config, buffer, least));
    TEST_ASSERT_EQUAL_INT(LODE_ERROR_NULL, lode_ring_init(&ring, NULL, buffer, least));
    TEST_ASSERT_EQUAL_INT(LODE_ERROR_NULL, lode_ring_init(&ring, &config, NULL, least));
    TEST_ASSERT_EQUAL_INT(LODE_ERROR_BUFFER, lode_ring_init(&ring, &config, buffer, least - 1u));
    TEST_ASSERT_EQUAL_INT(LODE_ERROR_BUFFER, lode_ring_init(&ring, &config, buffer, 0u));
    config.f_pwm_Hz = NAN;
    TEST_ASSERT_EQUAL_INT(LODE_ERROR_F_PWM, lode_ring_init(&ring, &config, buffer, least));
    TEST_ASSERT_EQUAL_MEMORY(&before, &ring, sizeof before);
    TEST_ASSERT_EQUAL_HEX32(0x5A5A5A5Au, buffer[0]);
}

static void test_most_channels_fit_the_header(void) {
    lode_channels_config_t config = {.f_pwm_Hz = 5000.0f, .count = LODE_CHANNELS_MAX};
    uint32_t words[LODE_RING_WORDS(LODE_CHANNELS_MAX, 2)];
    TEST_ASSERT_EQUAL_INT(LODE_OK, lode_ring_init(&ring, &config, words, COUNT_OF(words)));
    period();
    uint16_t octets[4 * (LODE_CHANNELS_MAX + 6) + 4];
    TEST_ASSERT_EQUAL_UINT32(COUNT_OF(octets), lode_ring_drain(&ring, octets, COUNT_OF(octets)));
    TEST_ASSERT_EQUAL_HEX16(0xA0u | 20u, octets[1]);
    TEST_ASSERT_EQUAL_HEX16(0x20u | 16u, octets[COUNT_OF(octets) - 3]);
}

static void test_interrupt_at_every_barrier(void) {
    for (uint32_t from = 0; from < 60u; from++) {
        for (uint32_t burst = 1; burst <= 8u; burst++) { // up to more than the ring holds
            source_init(&source);
            interrupts = 0u;
            start(7, 1);
            receiver_t receiver = {.decimation = 1};
            period();
            interrupts = burst;
            interrupt_from = from;
            barriers = 0u;
            uint16_t octets[13];
            for (int n = 0; n < 100; n++) {
                receive(&receiver, octets, lode_ring_drain(&ring, octets, 13u));
            }
            interrupts = 0u;
            drain(&receiver, 13u);
            period();
            drain(&receiver, 13u);
            TEST_ASSERT_EQUAL_UINT32(source.periods, receiver.frames + receiver.lost);
            TEST_ASSERT_EQUAL_UINT32(lode_ring_overruns(&ring), receiver.lost);
            TEST_ASSERT_EQUAL_UINT32(source.periods, receiver.next);
        }
    }
}

static void on_timer(int number) {
    (void)number;
    in_interrupt = true;
    const uint32_t burst = source.periods * 7u % 9u;
    for (uint32_t n = 0; n <= burst; n++) { // at times more than the ring holds
        period();
    }
    in_interrupt = false;
}

static void test_interrupt_by_a_timer(void) {
    start(7, 1);
    receiver_t receiver = {.decimation = 1};
    struct sigaction action = {.sa_handler = on_timer, .sa_flags = SA_RESTART};
    struct sigaction before;
    (void)sigemptyset(&action.sa_mask);
    TEST_ASSERT_EQUAL_INT(0, sigaction(SIGALRM, &action, &before));
    const struct itimerval fast = {{0, 20}, {0, 20}};
    const struct itimerval off = {{0, 0}, {0, 0}};
    (void)setitimer(ITIMER_REAL, &fast, NULL);
    // One by one, so that it takes long and most of the interrupts hit it.
    uint16_t octet = 0u;
    for (long n = 0; receiver.frames < 20000u && n < 50000000l; n++) {
        const uint32_t got = lode_ring_drain(&ring, &octet, 1u);
        if (got > 0u) {
            receive(&receiver, &octet, got);
        }
    }
    (void)setitimer(ITIMER_REAL, &off, NULL);
    (void)sigaction(SIGALRM, &before, NULL);
    drain(&receiver, 17u);
    period();
    drain(&receiver, 17u);
    TEST_ASSERT_TRUE(receiver.frames >= 20000u);
    TEST_ASSERT_EQUAL_UINT32(source.periods, receiver.frames + receiver.lost);
    TEST_ASSERT_EQUAL_UINT32(lode_ring_overruns(&ring), receiver.lost);
}

#if defined(__x86_64__) && defined(__linux__)

// Instructions between two strikes. A campaign (LODE_TEST_FULL=1) strikes at each of them.
static uint32_t stride(void) {
    const char *full = getenv("LODE_TEST_FULL");
#if defined(__OPTIMIZE__) && !defined(__SANITIZE_ADDRESS__)
    return full != NULL && strcmp(full, "1") == 0 ? 1u : 5u;
#else
    return full != NULL && strcmp(full, "1") == 0 ? 7u : 31u; // several times as many instructions
#endif
}

static volatile bool draining;
static volatile uint32_t instructions; // of the drain under way
static volatile uint32_t strike;       // the one behind which the interrupt comes

// The processor's trap flag: one of these signals after every instruction.
static void on_instruction(int number, siginfo_t *info, void *context) {
    greg_t *flags = &((ucontext_t *)context)->uc_mcontext.gregs[REG_EFL];
    const greg_t trap = 0x100;
    const bool begins = (*flags & trap) == 0;
    (void)number;
    (void)info;
    *flags |= trap;
    if (draining && instructions++ == strike) {
        on_timer(0);
        *flags &= ~trap;
    } else if (!draining && !begins && instructions > 0u) {
        *flags &= ~trap; // over before it came to that
    }
}

static void test_interrupt_between_instructions(void) {
    struct sigaction action = {.sa_sigaction = on_instruction, .sa_flags = SA_SIGINFO};
    struct sigaction before;
    (void)sigemptyset(&action.sa_mask);
    TEST_ASSERT_EQUAL_INT(0, sigaction(SIGTRAP, &action, &before));
    bool struck = true;
    for (strike = 0u; struck; strike += stride()) {
        source_init(&source);
        start(7, 1);
        receiver_t receiver = {.decimation = 1};
        for (uint32_t n = 0; n < 6u + strike % 2u; n++) {
            period();
        }
        uint16_t octets[DESCRIPTION_OCTETS + DATA_OCTETS + 8];
        const uint32_t head = DESCRIPTION_OCTETS + 2u; // from within a frame into the next one
        receive(&receiver, octets, lode_ring_drain(&ring, octets, head));
        instructions = 0u;
        const uint32_t periods = source.periods;
        (void)raise(SIGTRAP);
        draining = true;
        const uint32_t got = lode_ring_drain(&ring, octets, DATA_OCTETS + 2u);
        draining = false;
        struck = source.periods > periods;
        receive(&receiver, octets, got);
        drain(&receiver, 100u);
        period();
        drain(&receiver, 100u);
        TEST_ASSERT_EQUAL_UINT32(source.periods, receiver.frames + receiver.lost);
        TEST_ASSERT_EQUAL_UINT32(lode_ring_overruns(&ring), receiver.lost);
    }
    (void)sigaction(SIGTRAP, &before, NULL);
    TEST_ASSERT_TRUE(strike > 200u);
}

#endif

/// Whatever was in the memory, nothing is told as written or lost before the first period.
static void test_a_ring_begins_empty(void) {
    memset(buffer, 0x5A, sizeof buffer);
    start(4u, 1u);
    TEST_ASSERT_EQUAL_UINT32(0u, buffer[LODE_RING_AT_WRITTEN]);
    TEST_ASSERT_EQUAL_UINT32(0u, buffer[LODE_RING_AT_OVERRUNS]);
}

int main(void) {
    UNITY_BEGIN();
    RUN_TEST(test_frames_arrive_in_order_whatever_the_pieces);
    RUN_TEST(test_decimation);
    RUN_TEST(test_a_full_ring_leaves_out_and_counts);
    RUN_TEST(test_a_description_tells_overruns_and_long_gaps);
    RUN_TEST(test_buffer_is_described_for_a_debugger);
    RUN_TEST(test_nothing_behind_the_buffer_is_touched);
    RUN_TEST(test_bad_configurations_are_refused);
    RUN_TEST(test_most_channels_fit_the_header);
    RUN_TEST(test_interrupt_at_every_barrier);
    RUN_TEST(test_interrupt_by_a_timer);
#if defined(__x86_64__) && defined(__linux__)
    RUN_TEST(test_interrupt_between_instructions);
#endif
    RUN_TEST(test_a_ring_begins_empty);
    return UNITY_END();
}
