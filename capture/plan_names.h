/* SPDX-License-Identifier: Apache-2.0 */
/* plan_names.h: words of a resolved plan, for its writer and its reader. */
#ifndef TTF_CAPTURE_PRIVATE_PLAN_NAMES_H
#define TTF_CAPTURE_PRIVATE_PLAN_NAMES_H

extern const char *const ttf_lamp_mode_names[4]; /* by enum ttf_lamp_mode */
extern const char *const ttf_keep_names[4];      /* by enum ttf_keep */
extern const char *const ttf_plan_end_names[3];  /* by enum ttf_plan_end; of UNTOLD none */

#endif
