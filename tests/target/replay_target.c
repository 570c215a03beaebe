/// The replay in an image. Argument `flip`: with one input bit changed.
#include "replay.h"
#include "semihost.h"

int main(void) {
    uint64_t digest;
    if (!replay_all(replay_rows, semihost_has_argument("flip"), &digest)) {
        semihost_print("FAIL a drive was refused, or not in RUN at the end\n");
        return 1;
    }
    semihost_print_hex64(digest);
    semihost_print("\n");
    return 0;
}
