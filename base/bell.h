/* A bell: a descriptor that polls readable from when it was rung until it is silenced. How a thread wakes a loop that polls.
 * An int and not a struct: it is handed to poll, sd-event and borrowers; whoever made it closes it. Thread: all from any. */
#ifndef LF_BASE_BELL_H
#define LF_BASE_BELL_H

/* Silent; -1 when there are no descriptors left. */
int lf_bell_make(void);
/* However often: it never blocks, and is heard once. */
void lf_bell_ring(int bell);
/* Also one that was not rung. */
void lf_bell_silence(int bell);

#endif
