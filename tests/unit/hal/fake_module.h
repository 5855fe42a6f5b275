/* SPDX-License-Identifier: Apache-2.0 */
/* fake_module.h: what fake_module.c does on demand. */
#ifndef TTF_TESTS_HAL_FAKE_MODULE_H
#define TTF_TESTS_HAL_FAKE_MODULE_H

#define FAKE_BYTES 6144u /* of a buffer */

/* Exposures at which its process ends as by an assertion, never answers, or its camera is gone. */
#define FAKE_DIES_US  666.0
#define FAKE_HANGS_US 777.0
#define FAKE_GOES_US  888.0

#ifndef FAKE_ABI /* one of another version is made with another */
#define FAKE_ABI LC_ABI
#endif

#endif
