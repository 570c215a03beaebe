/// Host side of the replay: records the counts in a closed loop on the images' own plant.
///     replay_host counts          prints them as a C file
///     replay_host digest [flip]   replays them and prints the digest
#include <inttypes.h>
#include <stdio.h>
#include <string.h>

#include "plant.h"
#include "replay.h"

#define LOAD_Nm 2.0f

static replay_row_t recorded[REPLAY_CASES][REPLAY_ROWS];

static bool record(int32_t number) {
    static replay_t replay;
    plant_t plant;
    plant_init(&plant);
    plant.load_Nm = LOAD_Nm;
    if (!replay_begin(&replay, number, REPLAY_DIGEST)) {
        return false;
    }
    for (int32_t n = 0; n < REPLAY_ROWS; n++) {
        const lode_counts_t counts = plant_counts(&plant);
        recorded[number][n] = (replay_row_t){{counts.i[0], counts.i[1], counts.i[2]}, counts.v_bus};
        const lode_drive_out_t out = replay_step(&replay, &recorded[number][n]);
        plant_period(&plant, &out);
    }
    return replay.running > REPLAY_ROWS / 5; // else the record shows little of the drive
}

static void print_counts(void) {
    printf("#include \"replay.h\"\n\n"
           "const replay_row_t replay_rows[REPLAY_CASES][REPLAY_ROWS] = {\n");
    for (int32_t number = 0; number < REPLAY_CASES; number++) {
        printf("{\n");
        for (int32_t n = 0; n < REPLAY_ROWS; n++) {
            const replay_row_t *r = &recorded[number][n];
            printf("{{%u, %u, %u}, %u},\n", r->i[0], r->i[1], r->i[2], r->v_bus);
        }
        printf("},\n");
    }
    printf("};\n");
}

int main(int argc, char **argv) {
    for (int32_t number = 0; number < REPLAY_CASES; number++) {
        if (!record(number)) {
            fprintf(stderr, "case %d: refused, or for too short a time in RUN\n", (int)number);
            return 1;
        }
    }
    const bool flip = argc == 3 && strcmp(argv[2], "flip") == 0;
    if (argc == 2 && strcmp(argv[1], "counts") == 0) {
        print_counts();
        return 0;
    }
    if ((argc == 2 || flip) && strcmp(argv[1], "digest") == 0) {
        uint64_t digest;
        const bool good = replay_all((const replay_row_t(*)[REPLAY_ROWS])recorded, flip, &digest);
        printf("%016" PRIx64 "\n", digest);
        return good ? 0 : 1;
    }
    fprintf(stderr, "usage: replay_host counts | replay_host digest [flip]\n");
    return 2;
}
