/* The version of all programs, for --version and hello. */
#ifndef LF_BASE_VERSION_H
#define LF_BASE_VERSION_H

#define LF_VERSION "0.2.0"

#endif
