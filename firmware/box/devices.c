/* SPDX-License-Identifier: Apache-2.0 */
#include "devices.h"

#include <errno.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

#include "ttf/hal/lampd.h"
#include "ttf/hal/panel_lines.h"
#include "ttf/hal/sysfs.h"
#include "ttf/hal/systemd.h"
#include "ttf/hal/watchdog_device.h"

static int not_built_in(const char *backend, const char *where, struct ttf_err *err)
{
    return ttf_err_set(err, -ENOTSUP, where, "back-end '%s' is not built in", backend);
}

int box_make_camera(const struct ttf_board_camera *camera, struct ttf_clock *clock,
                    struct ttf_camera **ret, struct ttf_err *err)
{
    if (strcmp(camera->backend->name, "v4l2") == 0)
        return box_v4l2_camera(&camera->v4l2, clock, ret, err);
    if (strcmp(camera->backend->name, "libcamera") == 0)
        return box_libcamera_camera(&camera->libcamera, clock, ret, err);
    return not_built_in(camera->backend->name, camera->name, err);
}

/* "gpiod" and "file" say what the guardian holds; whoever wants light asks the guardian. */
int box_make_lamps(const struct ttf_board *board, struct ttf_clock *clock, struct ttf_lamps **ret,
                   struct ttf_err *err)
{
    int r = ttf_lamps_lampd_create(board->guardian.socket, clock, ret, err);

    if (r < 0)
        return r;
    /* A guardian that was started with another board knows other lamps. */
    for (unsigned i = 0; i < board->sim.n_lamps; i++) {
        if (ttf_lamps_find(*ret, board->sim.lamps[i].info.name) >= 0)
            continue;
        ttf_err_set(err, -ENODEV, board->guardian.socket, "the lamp guardian has no lamp '%s'",
                    board->sim.lamps[i].info.name);
        ttf_err_hint(err, "is it guarding another board? start ttfbox-lampd with this one");
        ttf_lamps_destroy(*ret);
        *ret = NULL;
        return -ENODEV;
    }
    return 0;
}

int box_make_sensors(const struct ttf_board *board, const struct box_host *host,
                     struct ttf_clock *clock, struct ttf_sensors **ret, struct ttf_err *err)
{
    return ttf_sensors_sysfs_create(host->sys ? host->sys : "/sys", board->sysfs, board->n_sysfs,
                                    clock, ret, err);
}

static int panel_lines(const struct ttf_board *board, struct ttf_lines **ret, struct ttf_err *err)
{
    const struct ttf_board_panel *panel = &board->panel;

    if (strcmp(board->device[TTF_DEVICE_PANEL]->name, "file") == 0)
        return ttf_lines_file_create(panel->file, panel->wires, panel->n_wires, ret, err);
    return box_gpiod_lines(panel->wires, panel->n_wires, ret, err);
}

int box_make_panel(const struct ttf_board *board, struct ttf_clock *clock, struct ttf_lamps *lamps,
                   struct ttf_panel **ret, struct ttf_err *err)
{
    struct ttf_panel_lines_config config = {
        .button = board->panel.button,
        .led = board->panel.led,
        .clock = clock,
        .lamps = lamps,
    };
    int r = board->panel.n_wires ? panel_lines(board, &config.lines, err) : 0;

    return r < 0 ? r : ttf_panel_lines_create(&config, ret, err);
}

int box_make_watchdog(const struct ttf_board *board, const struct box_host *host,
                      struct ttf_watchdog **ret, struct ttf_err *err)
{
    if (strcmp(board->device[TTF_DEVICE_WATCHDOG]->name, "device") == 0)
        return ttf_watchdog_device_create(board->watchdog_path, ret, err);
    if (!host->notify || !*host->notify || host->watchdog_ns <= 0)
        return 0;
    return ttf_watchdog_systemd_create(host->notify, host->watchdog_ns, ret, err);
}
