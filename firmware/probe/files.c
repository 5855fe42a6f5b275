/* SPDX-License-Identifier: Apache-2.0 */
#include "files.h"
#include "devices.h"

#include <dirent.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

void probe_machine_here(struct probe_machine *machine, const char *root)
{
    int n;

    memset(machine, 0, sizeof *machine);
    (void)snprintf(machine->root, sizeof machine->root, "%s", root ? root : "");
    machine->uid = geteuid();
    machine->groups[0] = getegid();
    n = getgroups(PROBE_GROUPS_MAX - 1, machine->groups + 1);
    machine->n_groups = 1 + (unsigned)(n > 0 ? n : 0);
    machine->line_holder = machine->root[0] ? NULL : box_gpiod_holder;
}

void probe_add(struct probe_findings *findings, enum probe_weight weight, const char *about,
               const char *hint, const char *fmt, ...)
{
    struct probe_finding *f;
    va_list args;

    if (findings->n == PROBE_FINDINGS_MAX)
        return;
    f = &findings->finding[findings->n++];
    f->weight = weight;
    (void)snprintf(f->about, sizeof f->about, "%s", about);
    (void)snprintf(f->hint, sizeof f->hint, "%s", hint ? hint : "");
    va_start(args, fmt);
    /* NOLINTNEXTLINE(clang-analyzer-valist.Uninitialized): it is begun above */
    (void)vsnprintf(f->text, sizeof f->text, fmt, args);
    va_end(args);
}

const char *probe_path(const struct probe_machine *machine, const char *path, char ret[512])
{
    (void)snprintf(ret, 512, "%s/%s", machine->root, path);
    return ret;
}

bool probe_line(const struct probe_machine *machine, const char *path, char *ret, size_t size)
{
    char whole[512];
    FILE *file = fopen(probe_path(machine, path, whole), "re");
    size_t n = 0;

    if (file) {
        n = fread(ret, 1, size - 1, file);
        (void)fclose(file);
    }
    ret[n] = '\0';
    ret[strcspn(ret, "\n")] = '\0';
    return file != NULL;
}

bool probe_stat(const struct probe_machine *machine, const char *path, struct stat *ret)
{
    char whole[512];

    return stat(probe_path(machine, path, whole), ret) == 0;
}

static int no_dots(const struct dirent *entry)
{
    return entry->d_name[0] != '.';
}

char **probe_names(const struct probe_machine *machine, const char *path)
{
    struct dirent **entries = NULL;
    char whole[512];
    int n = scandir(probe_path(machine, path, whole), &entries, no_dots, versionsort);
    char **names = calloc((size_t)(n > 0 ? n : 0) + 1, sizeof *names);

    for (int i = 0, kept = 0; i < n; i++) {
        if (names && (names[kept] = strdup(entries[i]->d_name)) != NULL)
            kept++;
        free(entries[i]);
    }
    free(entries);
    return names;
}

void probe_names_free(char **names)
{
    for (char **name = names; name && *name; name++)
        free(*name);
    free(names);
}

bool probe_may_use(const struct probe_machine *machine, const struct stat *st)
{
    if (machine->uid == 0)
        return true;
    if (st->st_uid == machine->uid)
        return (st->st_mode & 0600) == 0600;
    for (unsigned i = 0; i < machine->n_groups; i++)
        if (machine->groups[i] == st->st_gid)
            return (st->st_mode & 0060) == 0060;
    return (st->st_mode & 0006) == 0006;
}

static bool has_open(const struct probe_machine *machine, const char *process, const char *device)
{
    char folder[320], link[640], whole[512], target[256];
    bool found = false;
    char **fds;

    (void)snprintf(folder, sizeof folder, "proc/%s/fd", process);
    fds = probe_names(machine, folder);
    for (char **fd = fds; fd && *fd && !found; fd++) {
        ssize_t n;

        (void)snprintf(link, sizeof link, "%s/%s", folder, *fd);
        n = readlink(probe_path(machine, link, whole), target, sizeof target - 1);
        target[n > 0 ? n : 0] = '\0';
        found = strcmp(target, device) == 0;
    }
    probe_names_free(fds);
    return found;
}

/* This process, or one that it started: libcamera is in such a one (hal/libcamera). */
static bool is_own(const struct probe_machine *machine, const char *process, long number)
{
    char path[320], line[512];
    const char *after;
    long parent;

    if (number == (long)getpid())
        return true;
    (void)snprintf(path, sizeof path, "proc/%s/stat", process);
    if (!probe_line(machine, path, line, sizeof line))
        return false;
    after = strrchr(line, ')'); /* "number (name) state parent ...", and a name may have anything */
    return after && strlen(after) > 4 && (parent = strtol(after + 4, NULL, 10)) > 1 &&
           parent == (long)getpid();
}

long probe_holder(const struct probe_machine *machine, const char *device, char ret_name[64])
{
    char **processes = probe_names(machine, "proc");
    char path[320];
    long number = 0;

    for (char **p = processes; p && *p && number == 0; p++) {
        long candidate = strtol(*p, NULL, 10);

        if (candidate <= 0 || !has_open(machine, *p, device) || is_own(machine, *p, candidate))
            continue;
        number = candidate;
        (void)snprintf(path, sizeof path, "proc/%s/comm", *p);
        (void)probe_line(machine, path, ret_name, 64);
    }
    probe_names_free(processes);
    return number;
}
