/* SPDX-License-Identifier: Apache-2.0 */
/* paths.h: paths in a file count from that file's own folder; what a plan's path names. */
#ifndef CONFIG_PATHS_H
#define CONFIG_PATHS_H

/* Absolute and empty ones stay; what would become too long stays as it is, and is not found. */
void cfg_from_folder_of(const char *file, char path[512]);

/* The dataset of a plan, unless it is named: /etc/ttfbox/grass.yaml makes grass. */
void cfg_dataset_of_plan(const char *plan, char ret[128]);

#endif
