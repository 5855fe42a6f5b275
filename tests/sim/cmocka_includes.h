/* SPDX-License-Identifier: Apache-2.0 */
/* cmocka_includes.h: cmocka with what must come before it. */
#ifndef TTF_TESTS_CMOCKA_INCLUDES_H
#define TTF_TESTS_CMOCKA_INCLUDES_H

/* clang-format off */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>
/* clang-format on */

#endif
