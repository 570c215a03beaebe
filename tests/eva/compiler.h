// What depends on the compiler, for a reader who does not compile: no barriers, no hints.
#define LODE_INLINE static inline
#define LODE_NOINLINE
#define LODE_USUALLY(condition) (condition)
#define LODE_SIGNAL_FENCE() ((void)0)
#define LODE_SHARED_STORE(word, value) ((word) = (value))
#define LODE_SHARED_LOAD(word) (word)

// The duties of a period are there twice: in a variable, and in the drive, where they are kept.
#define EVA_WITHIN(duty, most)                                                                     \
    (lode_in_range((duty).a, 0.0f, most) && lode_in_range((duty).b, 0.0f, most) &&                 \
     lode_in_range((duty).c, 0.0f, most))
#define EVA_BOTH_WITHIN(own, self, most) (EVA_WITHIN(own, most) && EVA_WITHIN((self)->duty, most))
