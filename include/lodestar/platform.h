/// Everything that depends on the compiler.
#ifndef LODESTAR_PLATFORM_H
#define LODESTAR_PLATFORM_H

#if defined(__FAST_MATH__) || (defined(__FINITE_MATH_ONLY__) && __FINITE_MATH_ONLY__)
#error "Lodestar needs IEEE comparisons: build it without -ffast-math and -ffinite-math-only"
#endif

/// Placement of the interrupt's code. Define it, for instance as `__attribute__((section(".ccmram")))`, to put the
/// step functions into fast memory. Large and rare functions do not have it: MTPA, field weakening, and the
/// reactions to faults.
#ifndef LODE_RAMFUNC
#if defined(__TMS320C28XX__) // TI's section .TI.ramfunc
#define LODE_RAMFUNC __attribute__((ramfunc))
#else
#define LODE_RAMFUNC
#endif
#endif

/// A small kernel of the interrupt, which becomes part of its caller. With LODE_SMALL the compiler decides.
#ifndef LODE_INLINE
#if defined(__GNUC__) && !defined(LODE_SMALL)
#define LODE_INLINE static inline __attribute__((always_inline))
#else
#define LODE_INLINE static inline
#endif
#endif

/// The same for a larger or rarely called kernel. With LODE_SMALL it is a function that exists once: each file
/// compiles one, and the linker keeps the first (with -ffunction-sections and --gc-sections).
#ifndef LODE_SHARED
#if defined(LODE_SMALL) && defined(__GNUC__)
#define LODE_SHARED __attribute__((weak))
#else
#define LODE_SHARED LODE_INLINE
#endif
#endif

/// A function called from many places. With LODE_SMALL each of them makes a call, even if link-time optimisation
/// would inline the function.
#ifndef LODE_SMALL_CALL
#if defined(LODE_SMALL) && defined(__GNUC__)
#define LODE_SMALL_CALL __attribute__((noinline))
#else
#define LODE_SMALL_CALL
#endif
#endif

/// A rare branch of the interrupt, kept small and outside of the code that always runs. Not with LODE_SMALL: as
/// part of its only caller it is smaller.
#ifndef LODE_NOINLINE
#if defined(__GNUC__) && !defined(LODE_SMALL)
#define LODE_NOINLINE __attribute__((noinline, cold))
#else
#define LODE_NOINLINE
#endif
#endif

/// The usual outcome of a branch in the interrupt; its code is laid out without a jump. A hint is kept only if it
/// saves at least 5 cycles in a case of docs/budget.md, on a Cortex-M4F at -O2 with all other hints in place. The
/// figure is given next to the hint; `tests/run bench` without the hint shows it. All six together save 16 to 25
/// cycles of a mean call in RUN.
#ifndef LODE_USUALLY
#if defined(__GNUC__)
#define LODE_USUALLY(condition) __builtin_expect((condition), 1)
#else
#define LODE_USUALLY(condition) (condition)
#endif
#endif
#define LODE_RARELY(condition) (!LODE_USUALLY(!(condition)))

/// Compiler barrier for memory accesses. It orders a thread against an interrupt on the SAME core, which is all
/// that the mailboxes of a drive need.
#ifndef LODE_SIGNAL_FENCE
#if defined(__GNUC__)
#define LODE_SIGNAL_FENCE() __atomic_signal_fence(__ATOMIC_SEQ_CST)
#elif defined(__TMS320C28XX__)
// An empty function in a file of its own, port/ti_f28004x/startup.c: this compiler has no barrier, but cannot look into the
// call. Not with whole-program optimisation (--opt_level=4).
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

/// Access to one word that a thread and the interrupt share: a flag, a counter or a pointer. It is written and read
/// once and as a whole, by C11 atomics if the compiler has them and the core needs no lock for them, otherwise by
/// an ordinary access. Between two fences both have the same effect.
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
