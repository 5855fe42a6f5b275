/* SPDX-License-Identifier: Apache-2.0 */
/* files.h: the small files of a machine. Paths are as on the machine, without the first slash: "sys/class/udc". */
#ifndef FIRMWARE_PROBE_FILES_H
#define FIRMWARE_PROBE_FILES_H

#include <sys/stat.h>

#include "probe.h"

/* Its whole path. Returns ret. */
const char *probe_path(const struct probe_machine *machine, const char *path, char ret[512]);

/* A file's first line, without its end; also of a device tree's texts. false: it cannot be read, ret is "". */
bool probe_line(const struct probe_machine *machine, const char *path, char *ret, size_t size);

bool probe_stat(const struct probe_machine *machine, const char *path, struct stat *ret);

/* Names in a folder, in order; NULL-ended, freed by probe_names_free. Of a folder that is not there: none. */
char **probe_names(const struct probe_machine *machine, const char *path);
void probe_names_free(char **names);

/* Would reading and writing be allowed to machine's user? */
bool probe_may_use(const struct probe_machine *machine, const struct stat *st);

/* The process that has this device open ("/dev/video0"): its number, and its name; 0: nobody that can be seen. */
long probe_holder(const struct probe_machine *machine, const char *device, char ret_name[64]);

#endif
