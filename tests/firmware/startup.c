/*
 * Reset of a Cortex-M without an operating system: the vector table, variables,
 * the FPU where there is one, then main(). Input and output by semihosting,
 * which a debugger or qemu answers.
 */

#include <stdint.h>
#include <stdlib.h>

/* Set by firmware.ld. */
extern uint32_t data_load;
extern uint32_t data_start;
extern uint32_t data_end;
extern uint32_t bss_start;
extern uint32_t bss_end;
extern uint32_t stack_top;

extern int main(void);
/* Of newlib's librdimon: opens stdin, stdout and stderr. */
extern void initialise_monitor_handles(void);

void reset(void);
static void fault(void);

typedef void (*handler)(void);

struct vectors {
    uint32_t *stack;
    handler handlers[15];
};

extern const struct vectors vectors;
__attribute__((section(".vectors"), used)) const struct vectors vectors = {
    &stack_top,
    {reset, fault, fault, fault, fault, fault, 0, 0, 0, 0, fault, fault, 0, fault, fault}
};

void reset(void)
{
    const uint32_t *from = &data_load;
    for (uint32_t *to = &data_start; to < &data_end; to += 1) {
        *to = *from;
        from += 1;
    }
    for (uint32_t *to = &bss_start; to < &bss_end; to += 1) {
        *to = 0u;
    }
#ifdef __ARM_FP
    /* CPACR: full access to coprocessors 10 and 11, before the first instruction of theirs. */
    *(volatile uint32_t *)0xE000ED88u |= 0xFu << 20;
    __asm volatile("dsb\n\tisb" ::: "memory");
#endif
    initialise_monitor_handles();
    exit(main());
}

static void fault(void)
{
    _Exit(70);
}
