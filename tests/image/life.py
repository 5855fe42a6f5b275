# SPDX-License-Identifier: Apache-2.0
"""A box's life: power cuts, wrong settings, a larger card, the image written anew over the old one."""
import os
import random
import subprocess
import tempfile
import time

import booted
import boots
import capture

BOOTS = int(os.environ.get("TTFBOX_IMAGE_BOOTS", "2"))
PLAN = boots.PLAN


def records(m):
    code, out = m.run("grep -c '\"type\":\"slot\"' %s" % capture.RECORDS)
    return int(out.split()[-1]) if code == 0 else 0


def a_box_that_loses_its_power_goes_on_by_itself_on_the_grid(board, image):
    capture.card(board, image, PLAN)
    chance = random.Random(1)
    took, had = [], 0
    for boot in range(BOOTS + 1):
        with booted.Booted(image) as m:
            began = time.monotonic()
            m.wait("[ $(grep -c '\"type\":\"slot\"' %s) -gt %d ]" % (capture.RECORDS, had + 1), 300)
            took.append(m.booted_s + time.monotonic() - began)
            m.run("sleep %.2f" % (chance.random() * boots.INTERVAL_S))
            had = records(m)
            if boot < BOOTS:
                m.cut()
            else:
                m.off()
    with tempfile.TemporaryDirectory(prefix="ttfbox-image.") as folder:
        booted.take_out(image, "/datasets", folder)
        summary = boots.read.Reader(folder + "/datasets/plan").summary()
    assert summary["exit"] == 0, [f for f in summary["findings"] if f["class"] == "damage"][:3]
    assert len(summary["slots"]) >= had and len(summary["segments"]) == BOOTS + 1
    boots.expect_grid(summary, boots.INTERVAL_S * 10**9)
    results = [s["result"] for s in summary["slots"]]
    print("    %d cuts; %d slots: %s; all on the grid; captured again %.0f s after the kernel's start (longest)" %
          (BOOTS, len(results), ", ".join("%d %s" % (results.count(r), r) for r in sorted(set(results))), max(took)))


def state_of(m):
    m.wait("systemctl is-active ttfboxd ttfbox-lampd && %s | grep -q -e capturing -e armed" % capture.STATUS, 300)
    out = m.run("cat /etc/machine-id; ls /var/lib/ttfbox; df --output=size -BM /data | tail -n 1; stat -c %%U /var/lib/ttfbox/plan; %s" %
                capture.STATUS)[1].split()
    return {"id": out[0], "datasets": out[1], "mib": int(out[2].rstrip("M")), "owner": out[3], "status": " ".join(out[4:])}


def wrong_settings_are_told_and_the_former_stay_and_datasets_outlive_the_image(board, image):
    capture.card(board, image, capture.PLAN % (1500, "capture-only"))
    with booted.Booted(image) as m:
        first = state_of(m)
        m.off()
    assert booted.get(image, "ttfbox-problem.txt") is None

    booted.put(image, "settings/plan.yaml", "interval: 10\ncount: 5\n")
    with booted.Booted(image) as m:
        second = state_of(m)
        m.off()
    said = booted.get(image, "ttfbox-problem.txt")
    print("    a wrong plan: " + " | ".join(said.split("\r\n")))
    assert "settings/plan.yaml:1:11" in said and "former settings" in said, said
    assert (second["id"], second["datasets"]) == (first["id"], "plan"), second

    # The image is written anew, as with a card writer, and the card is a larger one.
    fresh = image + ".fresh"
    booted.copy(board, fresh)
    wrong = capture.SETTINGS.replace("set:", "unknown: 1\nset:")
    line = wrong[:wrong.index("unknown:")].count("\n") + 1
    booted.put(fresh, "settings/ttfbox.yaml", wrong)
    subprocess.run(["dd", "if=" + fresh, "of=" + image, "bs=1M", "conv=notrunc", "status=none"], check=True)
    os.unlink(fresh)
    subprocess.run(["truncate", "-s", "+1G", image], check=True)
    with booted.Booted(image) as m:
        third = state_of(m)
        m.off()
    said = booted.get(image, "ttfbox-problem.txt")
    print("    a wrong key: " + " | ".join(said.split("\r\n")))
    assert f"settings/ttfbox.yaml:{line}:1" in said and "unknown" in said, said
    assert (third["id"], third["datasets"], third["owner"]) == (first["id"], "plan", "ttfbox"), third
    assert 950 <= first["mib"] <= 1024 and 1900 <= third["mib"] <= 2048, (first, third)

    booted.put(image, "settings/ttfbox.yaml", capture.SETTINGS)
    booted.put(image, "settings/plan.yaml", capture.PLAN % (1500, "capture-only"))
    with booted.Booted(image) as m:
        last = state_of(m)
        code, out = m.run("grep -c '\"type\":\"segment\"' %s" % capture.RECORDS)
        assert int(out) == 4, out
        m.off()
    assert booted.get(image, "ttfbox-problem.txt") is None
    print("    first %d MiB for datasets, then %d; one machine's id, one dataset in four boots and two images; last: %s" %
          (first["mib"], last["mib"], last["status"]))


def a_card_that_is_too_small_is_told(board, image):
    booted.copy(board, image)
    with booted.Booted(image) as m:
        m.wait("systemctl is-active ttfbox-settings", 300)
        m.off()
    said = booted.get(image, "ttfbox-problem.txt")
    print("    " + " | ".join(said.split("\r\n")))
    assert "too small" in said and "nothing is captured" in said, said


def a_port_that_the_settings_make_a_host_is_no_device(board, image):
    """The services that are on for the board as it is shipped are left out; nothing has failed, and the box captures."""
    capture.card(board, image, capture.PLAN % (1500, "capture-only"))
    booted.put(image, "settings/ttfbox.yaml", capture.SETTINGS.replace("set: {", "set: {machine.usb_role: host, "))
    with booted.Booted(image) as m:
        state_of(m)
        m.wait("! systemctl list-jobs --no-legend --plain | grep -q .", 300)
        out = m.run("systemctl show -P ActiveState ttfbox-gadget ttfbox-usbd | xargs; cat /sys/class/udc/*/function; ls /sys/kernel/config/usb_gadget")[1]
        assert out.split("\n")[0] == "inactive inactive" and "ttfbox" not in out.split("\n", 1)[1], out + m.journal()
        assert m.run("systemctl --failed --no-legend --plain")[1].strip() == "", m.journal()
        m.off()
    assert booted.get(image, "ttfbox-problem.txt") is None


SCENARIOS = [a_box_that_loses_its_power_goes_on_by_itself_on_the_grid,
             wrong_settings_are_told_and_the_former_stay_and_datasets_outlive_the_image,
             a_card_that_is_too_small_is_told,
             a_port_that_the_settings_make_a_host_is_no_device]
