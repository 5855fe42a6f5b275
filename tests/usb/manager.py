# SPDX-License-Identifier: Apache-2.0
"""As much of a service manager as ttfbox-usbd needs: it keeps descriptors over a restart (sd_notify(3), "FDSTORE=1")."""
import array
import os
import socket
import threading


class Manager:
    def __init__(self, world):
        self.world, self.kept = world, {}
        self.ear = socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM)
        self.ear.bind(world.at("notify"))
        self.lock = threading.Lock()
        threading.Thread(target=self.listen, daemon=True).start()

    def listen(self):
        while True:
            text, control, _, _ = self.ear.recvmsg(4096, socket.CMSG_SPACE(8 * 4))
            fds = array.array("i")
            for level, kind, data in control:
                if (level, kind) == (socket.SOL_SOCKET, socket.SCM_RIGHTS):
                    fds.frombytes(data[:len(data) - len(data) % fds.itemsize])
            said = dict(line.split("=", 1) for line in text.decode().splitlines() if "=" in line)
            with self.lock:
                if "FDSTORE" in said and "FDPOLL" in said and len(fds) == 1:
                    self.kept[said["FDNAME"]] = fds.pop()
                if "FDSTOREREMOVE" in said and said["FDNAME"] in self.kept:
                    os.close(self.kept.pop(said["FDNAME"]))
            for fd in fds:
                os.close(fd)

    def begin(self, pid="$$"):
        """The service, with what is kept, for the process pid."""
        world = self.world
        n = world.log("usbd").count("ready at") if os.path.exists(world.at("usbd.log")) else 0
        with self.lock:
            names, fds = list(self.kept), list(self.kept.values())
        env = os.environ | {"NOTIFY_SOCKET": world.at("notify")}
        if fds:
            env |= {"LISTEN_FDS": str(len(fds)), "LISTEN_FDNAMES": ":".join(names)}

        def hand_over():
            for i, fd in enumerate(fds):
                os.dup2(fd, 3 + i)

        world.start("usbd", "sh", "-c", 'export LISTEN_PID=%s; exec "$@"' % pid, "sh", world.usbd, "--cable", world.at("cable"), "--server",
                    world.at("http"), env=env, preexec_fn=hand_over, close_fds=False)
        world.wait(lambda: world.log("usbd").count("ready at") > n, "usbd is not ready")
        world.wait(lambda: "ep0" in self.kept, "nothing is given to be kept")

    def end(self, number):
        """One process of the service; the others go with it."""
        worker = self.world.worker()
        self.world.kill("usbd", number)
        self.world.wait(lambda: not os.path.exists("/proc/%s" % worker), "its worker outlives it")

    def forget(self):
        with self.lock:
            for fd in self.kept.values():
                os.close(fd)
            self.kept.clear()
