/// Everything that depends on the compiler.
#ifndef LODESTAR_PLATFORM_H
#define LODESTAR_PLATFORM_H

#if defined(__FAST_MATH__) || (defined(__FINITE_MATH_ONLY__) && __FINITE_MATH_ONLY__)
#error "Lodestar needs IEEE comparisons: build it without -ffast-math and -ffinite-math-only"
#endif

/// Where the code of the interrupt goes. Define it (for instance as
/// `__attribute__((section(".ccmram")))`) to place every step function in fast memory. Large
/// and rare functions do without it: MTPA, field weakening, and what follows when something is wrong.
#ifndef LODE_RAMFUNC
#if defined(__TMS320C28XX__) // TI's section .TI.ramfunc
#define LODE_RAMFUNC __attribute__((ramfunc))
#else
#define LODE_RAMFUNC
#endif
#endif

/// A kernel of the interrupt: small, and inlined into the function that uses it. With LODE_SMALL the compiler decides.
#ifndef LODE_INLINE
#if defined(__GNUC__) && !defined(LODE_SMALL)
#define LODE_INLINE static inline __attribute__((always_inline))
#else
#define LODE_INLINE static inline
#endif
#endif

/// The same for what is larger, or called rarely. In a build with LODE_SMALL it is a function that exists
/// once: each file makes one, and the linker keeps the first (with -ffunction-sections and --gc-sections).
#ifndef LODE_SHARED
#if defined(LODE_SMALL) && defined(__GNUC__)
#define LODE_SHARED __attribute__((weak))
#else
#define LODE_SHARED LODE_INLINE
#endif
#endif

/// Called from many places: with LODE_SMALL a call in each of them, even where link-time optimisation would rather
/// inline it.
#ifndef LODE_SMALL_CALL
#if defined(LODE_SMALL) && defined(__GNUC__)
#define LODE_SMALL_CALL __attribute__((noinline))
#else
#define LODE_SMALL_CALL
#endif
#endif

/// A rare branch of the interrupt: kept out of the code that runs every time, and small. Not with LODE_SMALL: as a
/// part of the only function that calls it, it needs less code.
#ifndef LODE_NOINLINE
#if defined(__GNUC__) && !defined(LODE_SMALL)
#define LODE_NOINLINE __attribute__((noinline, cold))
#else
#define LODE_NOINLINE
#endif
#endif

/// Where a branch of the interrupt usually goes: the usual way is laid out without a jump. A hint stays where it
/// saves 5 cycles or more of a case of docs/budget.md, on a Cortex-M4F at -O2 with all the others in place. The figure
/// stands beside it; `tests/run bench` without the hint shows it. All six save 16 to 25 cycles of a mean call in RUN.
#ifndef LODE_USUALLY
#if defined(__GNUC__)
#define LODE_USUALLY(condition) __builtin_expect((condition), 1)
#else
#define LODE_USUALLY(condition) (condition)
#endif
#endif
#define LODE_RARELY(condition) (!LODE_USUALLY(!(condition)))

/// Keeps the compiler from moving memory accesses across it. It orders a thread against an
/// interrupt on the SAME core, which is all that the mailboxes of a drive need.
#ifndef LODE_SIGNAL_FENCE
#if defined(__GNUC__)
#define LODE_SIGNAL_FENCE() __atomic_signal_fence(__ATOMIC_SEQ_CST)
#elif defined(__TMS320C28XX__)
// An empty function in a file of its own, port/ti_f28004x/startup.c: this compiler has no barrier, but it
// cannot see into a call. Not with whole-program optimisation (--opt_level=4).
#ifdef __cplusplus
extern "C" void lode_fence(void);
#else
void lode_fence(void);
#endif
#define LODE_SIGNAL_FENCE() lode_fence()
#else
#error "define LODE_SIGNAL_FENCE() as a compiler barrier of your toolchain"
#endif
#endif

/// One word that a thread and the interrupt share: a flag, a counter or a pointer. Written and read once and
/// as a whole, where the compiler has the atomics of C11 and the core needs no lock for them; elsewhere by
/// an ordinary access, which between two fences is the same.
#ifndef LODE_SHARED_STORE
#if defined(__GNUC__) && __GCC_ATOMIC_BOOL_LOCK_FREE == 2 && __GCC_ATOMIC_POINTER_LOCK_FREE == 2
#define LODE_SHARED_STORE(word, value) __atomic_store_n(&(word), (value), __ATOMIC_RELAXED)
#define LODE_SHARED_LOAD(word) __atomic_load_n(&(word), __ATOMIC_RELAXED)
#else
#define LODE_SHARED_STORE(word, value) ((word) = (value))
#define LODE_SHARED_LOAD(word) (word)
#endif
#endif

#endif
