/* SPDX-License-Identifier: Apache-2.0 */
/* folder.h: the data folder. Nothing here leads out of it, and nothing writes. Any thread. */
#ifndef HTTP_FOLDER_H
#define HTTP_FOLDER_H

#include <dirent.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <sys/stat.h>

#include "ttf/base/attr.h"
#include "ttf/base/err.h"

struct folder {
    int fd;
    char path[4096];
};

/* -ENOENT, -ENOTDIR, ...; close it with folder_close. */
TTF_MUST_USE int folder_open(const char *path, struct folder *ret, struct ttf_err *err);
void folder_close(struct folder *folder);

/* 1 to 64 of A-Z a-z 0-9 . _ -, not beginning with a dot (dataset/FORMAT.md, "Names"). */
bool folder_is_name(const char *name);

/* Such names with '/' between, at most 191 bytes. */
bool folder_is_path(const char *path);

/*
 * Opens dataset/path for reading; no link is followed. ret_stat may be NULL. A descriptor, or -ENOENT: no such regular
 * file, or names that no dataset has.
 */
TTF_MUST_USE int folder_file(const struct folder *folder, const char *dataset, const char *path,
                             struct stat *ret_stat);

/* The same of what ttfbox-preview keeps beside a dataset: .preview/dataset/path of the data folder. */
TTF_MUST_USE int folder_preview(const struct folder *folder, const char *dataset, const char *path,
                                struct stat *ret_stat);

/* The path of a dataset's folder for libraries; -ENOENT if there is no dataset.json in it. */
TTF_MUST_USE int folder_dataset(const struct folder *folder, const char *dataset, char *ret,
                                size_t size);

/* The next entry of a folder that one thread reads. NULL: *ret_r is 0 at the end, or a negative errno. */
const struct dirent *folder_next(DIR *dir, int *ret_r);

/* Names of all datasets, in the order of their bytes, an array to be freed as one block; or a negative errno. One whose disk cannot be
 * read is among them; folders that this process may not look into are not. */
TTF_MUST_USE int64_t folder_list(const struct folder *folder, char (**ret)[65]);

/* May lines be added to this file of a dataset, also while it is read? People's notes may behind a seal, too. */
bool folder_grows(const char *path, bool sealed);

/* Bytes of a file of lines up to its last line end; or a negative errno. */
TTF_MUST_USE int64_t folder_whole_lines(int fd, int64_t bytes);

#endif
