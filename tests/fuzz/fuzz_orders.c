/* SPDX-License-Identifier: Apache-2.0 */
/* run.json, in which what was decided outlives a boot: what is taken says what to run, and is the same once written and read again. */
#include <stdlib.h>
#include <string.h>

#include "disk.h"
#include "fuzz.h"
#include "orders_file.h"

static void free_order(struct order *order)
{
    free(order->yaml);
}

static void check(const struct orders_file *file, const struct order *order)
{
    struct order again = {0};

    if (order->state < ORDER_RUN || order->state > ORDER_DONE)
        abort();
    if (order->state == ORDER_RUN && !*order->dataset)
        abort();
    if (orders_file_write(file, order, NULL) < 0 || orders_file_read(file, &again, NULL) != 1)
        abort();
    /* One that is done, and the configuration's own, is looked at anew at each boot. */
    if ((again.state != order->state && order->state != ORDER_DONE) ||
        strcmp(again.dataset, order->dataset) != 0 || again.by_request != order->by_request ||
        (order->yaml && strcmp(again.yaml, order->yaml) != 0))
        abort();
    free_order(&again);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    struct orders_file file;
    struct order order = {0};
    struct fuzz_disk disk;

    fuzz_disk_init(&disk);
    orders_file_name(&file, &disk.base, "state", "plan.yaml", "data/grass");
    fuzz_disk_put(&disk, "state/run.json", data, size);
    if (orders_file_read(&file, &order, NULL) == 1)
        check(&file, &order);
    else if (orders_file_put_aside(&file) < 0)
        abort();
    free_order(&order);
    if (fuzz_disk_open_handles(&disk) > 0)
        abort();
    fuzz_disk_free(&disk);
    return 0;
}
