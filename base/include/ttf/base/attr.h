/* SPDX-License-Identifier: Apache-2.0 */
/*
 * attr.h: the compiler attributes the tree uses, under one name each.
 *
 * Only what GCC and clang both know. Anything else (statement expressions,
 * cleanup attributes) is not used anywhere in this project.
 */
#ifndef TTF_BASE_ATTR_H
#define TTF_BASE_ATTR_H

/* The caller must look at the result. */
#define TTF_MUST_USE __attribute__((warn_unused_result))

/* printf-like: `fmt` is the 1-based index of the format, `args` of the first argument. */
#define TTF_PRINTF(fmt, args) __attribute__((format(printf, fmt, args)))

/* Number of elements of a true array. */
#define TTF_COUNT_OF(a) (sizeof(a) / sizeof((a)[0]))

#endif
