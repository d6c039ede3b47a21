/* Functions of known length, to check the counting by. */
    .syntax unified
    .thumb
    .text

    .global known_return
    .type known_return, %function
    .thumb_func
known_return:
    bx lr
    .size known_return, . - known_return

    /* known_loop(n): 3 + 2 n instructions. */
    .global known_loop
    .type known_loop, %function
    .thumb_func
known_loop:
    mov.w r1, #0
again:
    subs r0, r0, #1
    bne again
    cmp r1, #0
    bx lr
    .size known_loop, . - known_loop

    /* known_skip(n): 5, of which one is skipped where n is 0, and counts all the same. */
    .global known_skip
    .type known_skip, %function
    .thumb_func
known_skip:
    cmp r0, #0
    it ne
    movne r0, #1
    udiv r0, r0, r0
    bx lr
    .size known_skip, . - known_skip
