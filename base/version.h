/* The version of all programs, as --version and hello answer it. */
#ifndef LF_BASE_VERSION_H
#define LF_BASE_VERSION_H

#define LF_VERSION "0.2.0"

#endif
