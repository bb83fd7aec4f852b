/* A wakeup (eventfd): a descriptor that polls readable from its signal until it is cleared. Threads
 * use it to wake a polling loop. It is an int, not a struct, because it is passed to poll, sd-event
 * and borrowers; its creator closes it. Thread: all from any. */
#ifndef LF_BASE_WAKEUP_H
#define LF_BASE_WAKEUP_H

/* Makes one that is not signalled; -1: no descriptors are left. */
int lf_wakeup_make(void);
/* Signals it. Never blocks; repeated signals count once. */
void lf_wakeup_signal(int wakeup);
/* Clears it, signalled or not. */
void lf_wakeup_clear(int wakeup);

#endif
