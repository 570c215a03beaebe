// Temperature by the table of an NTC, against the equation that the table comes from.
#include "ntc.h"
#include "support/check.h"

#define B_K 3435.0
#define R25_Ohm 10000.0
#define FIXED_Ohm 4700.0
#define COLDEST -40
#define HOTTEST 150

static port_ntc_point_t points[(HOTTEST - COLDEST) / 10 + 1];

void setUp(void) {}

void tearDown(void) {}

static double resistance(double degC) {
    return R25_Ohm * exp(B_K * (1.0 / (degC + 273.15) - 1.0 / 298.15));
}

static uint32_t count_at(double degC, bool to_ground) {
    const double R = resistance(degC);
    return (uint32_t)((to_ground ? R : FIXED_Ohm) / (R + FIXED_Ohm) * 4096.0 + 0.5);
}

static port_ntc_t table(bool to_ground) {
    port_ntc_t ntc;
    for (int n = 0; n < COUNT_OF(points); n++) {
        points[n].degC = (float)(COLDEST + 10 * n);
        points[n].R_Ohm = (float)resistance((double)points[n].degC);
    }
    port_ntc_init(&ntc,
                  &(port_ntc_config_t){points, COUNT_OF(points), (float)FIXED_Ohm, to_ground});
    return ntc;
}

static double read(const port_ntc_t *ntc, uint32_t count) {
    return (double)port_ntc_tenths(ntc, count) * (double)PORT_NTC_GAIN_degC +
           (double)PORT_NTC_ZERO_degC;
}

static void test_reads_the_temperature(void) {
    for (int to_ground = 0; to_ground < 2; to_ground++) {
        const port_ntc_t ntc = table(to_ground != 0);
        for (double degC = -20.0; degC <= 110.0; degC += 0.5) {
            CHECK_NEAR(1.0, degC, read(&ntc, count_at(degC, to_ground != 0)));
        }
        for (double degC = 0.0; degC <= 90.0; degC += 0.5) {
            CHECK_NEAR(0.6, degC, read(&ntc, count_at(degC, to_ground != 0)));
        }
    }
}

static void test_ends(void) {
    for (int to_ground = 0; to_ground < 2; to_ground++) {
        const port_ntc_t ntc = table(to_ground != 0);
        const uint32_t broken = to_ground != 0 ? 4095u : 0u;
        TEST_ASSERT_EQUAL_UINT16(PORT_NTC_MISSING, port_ntc_tenths(&ntc, broken));
        CHECK_AT_LEAST(140.0, read(&ntc, 4095u - broken)); // a short is hot
        // No count that a temperature of use can make is taken for a missing sensor.
        TEST_ASSERT_TRUE(port_ntc_tenths(&ntc, count_at(-20.0, to_ground != 0)) < PORT_NTC_MISSING);
    }
}

// A hotter sensor never reads colder: a limit that is reached stays reached.
static void test_monotonic(void) {
    const port_ntc_t ntc = table(true);
    for (uint32_t count = 1u; count < 4096u; count++) {
        TEST_ASSERT_TRUE(port_ntc_tenths(&ntc, count) <= port_ntc_tenths(&ntc, count - 1u) ||
                         port_ntc_tenths(&ntc, count) == PORT_NTC_MISSING);
    }
}

int main(void) {
    UNITY_BEGIN();
    RUN_TEST(test_reads_the_temperature);
    RUN_TEST(test_ends);
    RUN_TEST(test_monotonic);
    return UNITY_END();
}
