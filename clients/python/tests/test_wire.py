"""The connection, with a daemon that answers in any order, slowly or not at all."""

import os
import socket
import tempfile
import threading
import unittest
from unittest import mock

import quiltd
from fake import FakeCase, Refused
from quiltd import wire


class Answers(FakeCase):
    def test_answers_are_matched_by_id(self):
        held = []
        ids = iter(range(100))

        def status(params, files):
            held.append(next(ids))
            if len(held) < 3:
                return None
            for number in (2, 4, 3):  # hello was 1
                self.fake.send({"jsonrpc": "2.0", "id": number, "result": {"number": number}})
            return None

        self.fake.answers["status"] = status
        results = [None] * 3

        def ask(i):
            results[i] = self.q.status()["number"]

        threads = [threading.Thread(target=ask, args=(i,)) for i in range(3)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        self.assertEqual(sorted(results), [2, 3, 4])

    def test_threads_share_a_connection(self):
        self.fake.answers["camera.orbit"] = lambda params, files: {"generation": int(params["yaw"])}
        wrong = []

        def turn(first):
            for yaw in range(first, first + 50):
                if self.q.camera.orbit(yaw=yaw)["generation"] != yaw:
                    wrong.append(yaw)

        threads = [threading.Thread(target=turn, args=(1000 * i,)) for i in range(6)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        self.assertEqual(wrong, [])
        self.assertEqual(len(self.sent("camera.orbit")), 300)

    def test_a_waiting_thread_holds_up_no_other(self):
        waits = threading.Event()
        self.fake.answers["export"] = lambda params, files: waits.set()  # no answer
        failed = []

        def export():
            try:
                self.q.export("still")
            except quiltd.ConnectionClosed as error:
                failed.append(error)

        thread = threading.Thread(target=export)
        thread.start()
        waits.wait()
        self.assertEqual(self.q.status(), {})
        self.q.close()
        thread.join()
        self.assertEqual(len(failed), 1)

    def test_a_call_that_timed_out_leaves_the_connection_usable(self):
        self.fake.answers["status"] = lambda params, files: None
        with self.assertRaises(TimeoutError):
            self.q.call("status", timeout=0.01)
        self.fake.send({"jsonrpc": "2.0", "id": 2, "result": {"late": True}})
        self.assertEqual(self.q.camera.orbit(yaw=1), {})

    def test_a_long_call_keeps_its_descriptors(self):
        sizes = []
        self.fake.answers["scene.load"] = lambda params, files: sizes.append(os.fstat(files[0]).st_size) or {"length": len(params["file"])}
        with tempfile.TemporaryFile() as file:
            file.write(b"12345")
            file.flush()
            self.assertEqual(self.q.call("scene.load", {"file": "x" * 900_000}, [file.fileno()]), {"length": 900_000})
        self.assertEqual(sizes, [5])

    def test_a_descriptor_that_is_not_open_is_refused(self):
        with self.assertRaises(quiltd.ParameterError):
            self.q.call("status", {}, [99999])
        self.assertEqual(self.q.status(), {})

    def test_a_call_beyond_a_mebibyte_is_not_sent(self):
        with self.assertRaises(quiltd.ParameterError):
            self.q.call("scene.load", {"file": "x" * (1 << 20)})
        self.assertEqual(self.sent("scene.load"), [])


class Errors(FakeCase):
    def refuse(self, code, **more):
        def answer(params, files):
            raise Refused({"code": code, "message": f"error {code}", **more})

        self.fake.answers["status"] = answer

    def test_codes_are_classes(self):
        kinds = {
            -32601: AttributeError,
            -32602: ValueError,
            -32603: quiltd.InternalError,
            -32000: quiltd.Busy,
            -32001: PermissionError,
            -32002: quiltd.BadScene,
            -32003: quiltd.NoDevice,
            -32004: TimeoutError,
            -1: quiltd.QuiltdError,
        }
        for code, kind in kinds.items():
            self.refuse(code)
            with self.assertRaises(kind) as caught:
                self.q.status()
            self.assertIsInstance(caught.exception, quiltd.QuiltdError)
            self.assertEqual(caught.exception.code, code)
            self.assertEqual(str(caught.exception), f"error {code}")
            self.assertEqual(caught.exception.data, {})

    def test_data_names_the_place(self):
        self.refuse(-32002, data={"file": "a.json", "line": 3, "pointer": "/camera"})
        with self.assertRaises(quiltd.BadScene) as caught:
            self.q.status()
        self.assertEqual(caught.exception.data, {"file": "a.json", "line": 3, "pointer": "/camera"})

    def test_an_end_of_the_daemon_is_an_exception(self):
        self.fake.answers["status"] = lambda params, files: self.fake.connections[-1].shutdown(socket.SHUT_RDWR)
        for _ in range(2):
            with self.assertRaises(ConnectionError):
                self.q.status()

    def test_the_reason_of_the_end_is_kept(self):
        def too_many(params, files):
            self.fake.send({"jsonrpc": "2.0", "id": None, "error": {"code": -32000, "message": "too many clients"}})
            self.fake.connections[-1].shutdown(socket.SHUT_RDWR)

        self.fake.answers["status"] = too_many
        with self.assertRaisesRegex(quiltd.ConnectionClosed, "too many clients"):
            self.q.status()

    def test_last_words_are_read_after_the_end(self):
        self.fake.send({"jsonrpc": "2.0", "id": None, "error": {"code": -32000, "message": "too many clients"}})
        self.fake.connections[-1].close()
        with self.assertRaisesRegex(quiltd.ConnectionClosed, "too many clients"):
            self.q.status()

    def test_without_a_daemon_all_sockets_are_named(self):
        with tempfile.TemporaryDirectory() as folder:
            with mock.patch.dict(os.environ, {"QUILTD_SOCKET": folder + "/a", "XDG_RUNTIME_DIR": folder}):
                self.assertEqual(wire.sockets(), [folder + "/a", folder + "/quiltd.sock", "/run/quiltd/control.sock"])
                with mock.patch("quiltd.client.sockets", lambda: [folder + "/a", folder + "/quiltd.sock"]):
                    with self.assertRaisesRegex(quiltd.NoDaemon, "/a: .*/quiltd.sock: "):
                        quiltd.connect()
            with mock.patch.dict(os.environ, {"QUILTD_SOCKET": "", "XDG_RUNTIME_DIR": "relative"}):
                self.assertEqual(wire.sockets(), ["/run/quiltd/control.sock"])

    def test_without_a_daemon_the_remedy_is_named(self):
        with self.assertRaisesRegex(quiltd.NoDaemon, r"^no quiltd answers \(/nowhere/s: No such file or directory\); start one: quiltd"):
            quiltd.connect("/nowhere/s")

    def test_a_url_is_refused(self):
        for url in ("http://127.0.0.1:8033/#token", "ws://127.0.0.1:8033/rpc"):
            with self.assertRaisesRegex(quiltd.ParameterError, "is a URL; Python needs the path of the socket"):
                quiltd.connect(url)

    def test_the_first_socket_that_answers_is_taken(self):
        with mock.patch("quiltd.client.sockets", lambda: [self.fake.path + ".none", self.fake.path]):
            with quiltd.connect() as q:
                self.assertEqual(q.info["version"], "0.0.0")

    def test_after_with_the_connection_is_closed(self):
        with quiltd.connect(self.fake.path) as q:
            pass
        with self.assertRaises(quiltd.ConnectionClosed):
            q.status()


class Notifications(FakeCase):
    def test_they_come_in_order_and_only_those_asked_for(self):
        events = self.q.events("frame", timeout=5)
        self.assertEqual(self.sent("subscribe"), [{"events": ["frame"]}])
        for generation in (1, 2, 3):
            self.fake.notify("scene", generation=generation)
            self.fake.notify("frame", generation=generation)
        self.q.status()  # they come while something else is awaited
        self.assertEqual([next(events)["generation"] for _ in range(3)], [1, 2, 3])

    def test_an_event_has_a_name_and_params(self):
        with self.q.events("scene", timeout=5) as events:
            self.fake.notify("scene", generation=4, file="a.json")
            name, params = event = next(events)
        self.assertEqual((name, params, event["file"]), ("scene", {"generation": 4, "file": "a.json"}, "a.json"))

    def test_subscriptions_add_up_and_end(self):
        frames = self.q.events("frame")
        scenes = self.q.events("scene")
        frames.close()
        scenes.close()
        scenes.close()
        self.assertEqual([p["events"] for p in self.sent("subscribe")], [["frame"], ["frame", "scene"], ["scene"], []])
        self.assertEqual(list(frames), [])

    def test_the_loop_ends_when_nothing_comes(self):
        self.assertEqual(list(self.q.events("frame", timeout=0.01)), [])

    def test_a_loop_that_was_left_gathers_nothing(self):
        self.fake.answers["status"] = lambda params, files: self.fake.notify("frame", generation=1) or {}
        events = self.q.events("frame", timeout=5)
        self.q.status()
        for event in events:
            break
        del events
        self.assertEqual((event["generation"], len(self.q._connection._inboxes)), (1, 0))
        self.q.events("scene")
        self.assertEqual(self.sent("subscribe")[-1], {"events": ["scene"]})

    def test_an_unknown_word_is_refused(self):
        with self.assertRaisesRegex(quiltd.ParameterError, "frames"):
            self.q.events("frames")

    def test_unread_events_are_bounded(self):
        events = self.q.events("frame", timeout=5)
        line = '{"jsonrpc": "2.0", "method": "frame", "params": {"generation": %d}}\n'
        lines = "".join(line % generation for generation in range(wire.KEPT_EVENTS + 10))
        self.fake.connections[-1].sendall(lines.encode())
        self.q.status()
        self.assertEqual(next(events)["generation"], 10)


class Exports(FakeCase):
    def end_with(self, state, **more):
        def export(params, files):
            for i, file in enumerate(files):
                os.write(file, f"file {i}".encode())
            for job, progress in ((6, "done"), (7, "running"), (7, state)):
                self.fake.notify("export", job=job, state=progress, **more)
            return {"job": 7, "file": params["file"]}

        self.fake.answers["export"] = export

    def test_one_file_is_bytes(self):
        self.end_with("done")
        self.assertEqual(self.q.export("quilt", wait="complete"), b"file 0")
        self.assertEqual(self.sent("export"), [{"kind": "quilt", "file": "quilt.png", "wait": "complete", "fds": 1}])

    def test_several_files_are_a_list(self):
        self.end_with("done")
        self.fake.answers["status"] = lambda params, files: {"views": 3}
        self.assertEqual(self.q.export("views"), [b"file 0", b"file 1", b"file 2"])
        self.assertEqual(self.q.export("print"), [b"file 0", b"file 1"])
        self.assertEqual([p["file"] for p in self.sent("export")], ["views/", "print.tif"])

    def test_a_failure_is_the_error_of_the_job(self):
        self.end_with("failed", error={"code": -32003, "message": "no panel"})
        with self.assertRaisesRegex(quiltd.NoDevice, "no panel"):
            self.q.export("panel")

    def test_a_cancelled_job_is_an_error(self):
        self.end_with("cancelled")
        with self.assertRaises(quiltd.Cancelled):
            self.q.export("still")

    def test_a_job_that_takes_too_long_is_ended(self):
        self.end_with("running")
        with self.assertRaises(TimeoutError):
            self.q.export("still", timeout=0.05)
        self.assertEqual(self.sent("job.cancel"), [{"job": 7}])

    def test_no_descriptor_is_left_open(self):
        self.end_with("failed", error={"code": -32603, "message": "disk full"})
        before = len(os.listdir("/proc/self/fd"))
        with self.assertRaises(quiltd.InternalError):
            self.q.export("print")
        self.q.status()  # the daemon of this process has closed its own
        self.assertEqual(len(os.listdir("/proc/self/fd")), before)


if __name__ == "__main__":
    unittest.main()
