/* A wakeup (eventfd): a descriptor that polls readable from its signal until it is cleared. How a
 * thread wakes a loop that polls. An int and not a struct: it is handed to poll, sd-event and
 * borrowers; whoever made it closes it. Thread: all from any. */
#ifndef LF_BASE_WAKEUP_H
#define LF_BASE_WAKEUP_H

/* Not signalled; -1 when there are no descriptors left. */
int lf_wakeup_make(void);
/* However often: it never blocks, and counts once. */
void lf_wakeup_signal(int wakeup);
/* Also one that was not signalled. */
void lf_wakeup_clear(int wakeup);

#endif
