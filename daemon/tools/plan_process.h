/* Time and memory of this process. Thread: the main thread. */
#ifndef LF_DAEMON_PLAN_PROCESS_H
#define LF_DAEMON_PLAN_PROCESS_H

/* CPU seconds of this process and of its ended children. */
double lf_process_cpu(void);
/* Resident memory in bytes. 0: unknown. */
double lf_process_memory(void);
/* Its peak since the start, or since lf_process_forget_peak. */
double lf_process_peak(void);
/* The largest peak of an ended child. */
double lf_process_child_peak(void);
/* Lets the peak begin with what is resident now, where the kernel allows it. */
void lf_process_forget_peak(void);

#endif
