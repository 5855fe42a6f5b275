# SPDX-License-Identifier: Apache-2.0
"""The PC's image in an emulated PC (UEFI): vivid as its webcam, no lamps."""
import booted
import capture

BOARD = """board: box
cameras: {main: {backend: v4l2, name: vivid, format: YUYV, width: 320, height: 180, frame_period: 40ms}}
clock: {backend: machine}
watchdog: {backend: systemd}
"""
SETTINGS = "board: boards/box/board.yaml\nplan: plan.yaml\ndata: /var/lib/ttfbox\n"
PLAN = "interval: 1s\ncount: 20\nreserve: 1MB\n"


def a_pc_boots_and_captures_with_a_board_of_its_own(board, image):
    capture.card(board, image, PLAN)
    booted.put(image, "settings/ttfbox.yaml", SETTINGS)
    booted.put(image, "settings/boards/box/board.yaml", BOARD)
    with booted.Booted(image, arch="amd64", memory=1024) as m:
        print("    its agent answered %.0f s after the kernel's start" % m.booted_s)
        code, out = m.run("modprobe vivid n_devs=1 node_types=0x1 num_inputs=1 input_types=0x00", 120)
        assert code == 0, out
        m.wait("%s | grep -q done" % capture.STATUS, 400)
        capture.expect_sealed_off(m)
        code, out = m.run("systemctl is-active ttfboxd; for p in ActiveState NRestarts ExecMainStatus; do systemctl show -P $p ttfbox-lampd; done; "
                          "ttfbox verify -q /var/lib/ttfbox/plan; echo $?; grep -c '\"result\":\"captured\"' %s" % capture.RECORDS, 200)
        print("    ttfboxd, the guardian that has nothing to guard, verify, captured: " + " ".join(out.split()))
        words = out.split()
        assert words[1:4] == ["inactive", "0", "4"], out + m.journal()
        assert words[0] == "active" and words[-2] == "0" and int(words[-1]) >= 19, out + m.journal()
        m.off()
    assert booted.get(image, "ttfbox-problem.txt") is None


SCENARIOS = [a_pc_boots_and_captures_with_a_board_of_its_own]
