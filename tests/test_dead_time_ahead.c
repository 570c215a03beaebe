// The current by which dead time is corrected: that of the middle of the period in which the duties act.
#include "support/rig.h"

#include "drive_inline.h"

void setUp(void) {}

void tearDown(void) {}

/// (I11): a quarter of the way to the reference, 1 - exp(-1.5 * 0.2). With injection it is the reference (H19).
static void test_dead_time_goes_by_a_current_on_its_way(void) {
    for (int injects = 0; injects <= 1; injects++) {
        static lode_drive_tuning_t tuning;
        const lode_drive_config_t config = rig_config();
        rig_t rig;
        rig_init(&rig, &tuning, &config);
        rig.drive.estimator.by.hfi.active = injects != 0;
        rig.drive.u_V = (lode_dq_t){5.0f, -7.0f};
        rig.drive.ref_A = (lode_dq_t){3.0f, -4.0f};
        const lode_frame_t frame = {.i_A = {1.0f, 2.0f}};
        const lode_demand_t demand = lode_drive_demand(&rig.drive, &tuning, &frame);
        const double share = injects != 0 ? 1.0 : 1.0 - exp(-0.3);
        CHECK_NEAR(0.01, 1.0 + share * 2.0, demand.i_A.d);
        CHECK_NEAR(0.01, 2.0 - share * 6.0, demand.i_A.q);
        if (injects == 0) {
            TEST_ASSERT_EQUAL_FLOAT(5.0f, demand.u_V.d);
            TEST_ASSERT_EQUAL_FLOAT(-7.0f, demand.u_V.q);
        }
    }
}

int main(void) {
    UNITY_BEGIN();
    RUN_TEST(test_dead_time_goes_by_a_current_on_its_way);
    return UNITY_END();
}
