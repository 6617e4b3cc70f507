#!/usr/bin/env python3
"""What a client of ilp-ground serve sees: http_test.py ILP_GROUND MAKE_DOWNLINK WORK [TEST...]"""
import http.client
import json
import os
import shutil
import socket
import subprocess
import sys
import unittest

from served import (Flood, Server, SlowConnections, Stream, deliver, foreign_hosts, of_keyframes, own_hosts, patience_s,
                    run_side_by_side, wait_for, with_the_test)

ground, make_downlink, work = sys.argv[1:4]
source = os.path.join(work, "downlink")
keyframes = 8


class Serve(unittest.TestCase):
    def setUp(self):
        self.folder = os.path.join(work, self.id().rsplit(".", 1)[1])
        shutil.rmtree(self.folder, ignore_errors=True)
        self.box, self.out = os.path.join(self.folder, "box"), os.path.join(self.folder, "box-ground")
        os.makedirs(self.box)

    def serve(self, *options):
        server = Server(ground, self.box, "--listen", "127.0.0.1:0", *options)
        self.addCleanup(server.end)
        return server

    def serve_whole(self):
        deliver(source, self.box, os.listdir(source))
        server = self.serve()
        wait_for("the flight", lambda: server.state().get("totals", {}).get("final_poses") == keyframes)
        wait_for("the end of the run", lambda: server.state()["run"]["state"] == "waiting")
        return server

    def test_keyframes_appear_on_an_open_page_as_their_files_arrive(self):
        server = self.serve()
        stream = Stream(server)
        wait_for("the greeting", lambda: stream.items.get("run", {}).get("state") == "waiting")
        self.assertEqual(stream.items["run"]["problem"], "")
        for last in (2, 5, keyframes):
            deliver(source, self.box, of_keyframes(source, max(1, last - 2), last))
            wait_for(f"keyframe {last}", lambda: stream.keyframes() == list(range(1, last + 1)))
            self.assertEqual(stream.items["totals"]["keyframes"], last)
            self.assertEqual(stream.items["strips/1"]["final_poses"], last)
        wait_for("the end of the run", lambda: stream.items["run"]["state"] == "waiting")
        self.assertEqual(stream.items["run"]["problem"], "")
        # The truth of the downlink: the camera flies along x, 80 % of the image overlaps, at equal steps.
        x = [stream.items[f"keyframes/{i}"]["pose"]["centre"][0] for i in range(1, keyframes + 1)]
        steps = [b - a for a, b in zip(x, x[1:])]
        for step in steps:
            self.assertAlmostEqual(step, steps[0], delta=1e-4 * abs(steps[0]))
        files = [os.path.getsize(os.path.join(self.box, n)) for n in os.listdir(self.box)]
        self.assertEqual(stream.items["totals"]["received_bytes"], sum(files))

    def test_only_what_has_changed_is_sent(self):
        server = self.serve()
        deliver(source, self.box, of_keyframes(source, 1, keyframes - 1))
        stream = Stream(server)
        wait_for("the flight", lambda: stream.items.get("totals", {}).get("final_poses") == keyframes - 1)
        before = len(stream.updates)
        deliver(source, self.box, of_keyframes(source, keyframes, keyframes))
        wait_for("the last keyframe", lambda: keyframes in stream.keyframes())
        sent = {name for update, _ in stream.updates[before:] for name in update["set"] if name.startswith("keyframes/")}
        self.assertNotIn("keyframes/1", sent)
        self.assertIn(f"keyframes/{keyframes}", sent)
        self.assertEqual(stream.items, {**server.state(), "run": stream.items["run"]})

    def test_a_page_that_comes_back_gets_what_it_has_missed(self):
        server = self.serve()
        deliver(source, self.box, of_keyframes(source, 1, 4))
        stream = Stream(server)
        wait_for("the flight", lambda: stream.items.get("totals", {}).get("final_poses") == 4)
        wait_for("the end of the run", lambda: stream.items["run"]["state"] == "waiting")
        stream.close()
        deliver(source, self.box, of_keyframes(source, 5, 5))
        wait_for("keyframe 5", lambda: "keyframes/5" in server.state())
        again = Stream(server, stream.place)
        wait_for("keyframe 5 on the page", lambda: 5 in again.keyframes())
        self.assertFalse(again.updates[0][0]["full"])
        self.assertNotIn("keyframes/1", again.items)
        for nonsense in ("0-1", "x", "-", "ffffffffffffffff-99999999999999999999", stream.place + "9"):
            afresh = Stream(server, nonsense)
            wait_for("everything", lambda: afresh.keyframes() == [1, 2, 3, 4, 5])
            self.assertTrue(afresh.updates[0][0]["full"])

    def test_a_restart_of_the_server_loses_nothing(self):
        server = self.serve_whole()
        stream = Stream(server)
        wait_for("the flight", lambda: len(stream.keyframes()) == keyframes)
        place, before = stream.place, server.state()
        server.end()
        # The outbox is emptied, as a station does that has its files in the results.
        for name in of_keyframes(source, 1, keyframes):
            os.remove(os.path.join(self.box, name))
        server = self.serve()
        again = Stream(server, place)
        wait_for("the flight", lambda: len(again.keyframes()) == keyframes)
        self.assertTrue(again.updates[0][0]["full"])
        wait_for("the end of the run", lambda: server.state()["run"]["state"] == "waiting")
        after = server.state()
        lists = ("keyframes/", "strips/", "events/", "figures/")
        self.assertEqual({k: v for k, v in after.items() if k.startswith(lists)}, {k: v for k, v in before.items() if k.startswith(lists)})

    def test_the_page_needs_nothing_from_elsewhere(self):
        server = self.serve_whole()
        status, headers, page = server.get("/")
        self.assertEqual((status, headers["Content-Type"]), (200, "text/html; charset=utf-8"))
        self.assertIn("default-src 'none'", headers["Content-Security-Policy"])
        for part in ("live.css", "main.js", "connection.js", "zoom.js", "sections.js", "figures.js", "plot.js", "text.js", "style.css"):
            status, headers, text = server.get("/page/" + part)
            self.assertEqual(status, 200, part)
            self.assertNotIn(b"http://", text)
            self.assertNotIn(b"https://", text)
        self.assertNotIn(b"http://", page + text)

    def test_files_are_those_of_the_results(self):
        server = self.serve_whole()
        files = server.state()["results"]
        self.assertEqual(files, sorted(set(files)))
        for name in files + ["keyframes/000001-image.png"]:
            status, headers, content = server.get("/files/" + name)
            # What lies in the results acts for nobody who has the page open.
            self.assertTrue(headers["Content-Security-Policy"].startswith("sandbox allow-scripts"), name)
            self.assertNotIn("allow-same-origin", headers["Content-Security-Policy"])
            with open(os.path.join(self.out, name), "rb") as file:
                self.assertEqual((status, content), (200, file.read()), name)
        figure = server.state()["figures/strip 1"]
        for picture in (figure, figure["heights"]):
            status, headers, content = server.get(picture["href"])
            self.assertEqual((status, headers["Content-Type"], content[:4]), (200, "image/png", b"\x89PNG"))
            size = [int.from_bytes(content[at:at + 4], "big") for at in (16, 20)]
            self.assertEqual(size, [picture["view"]["width"], picture["view"]["height"]])

    def assert_same(self, item, value, name):
        """But for the digits that are not sent."""
        if isinstance(value, float):
            self.assertAlmostEqual(item, value, delta=1e-8 * abs(value), msg=name)
        elif isinstance(value, dict):
            self.assertEqual(set(item), set(value), name)
            for key in value:
                self.assert_same(item[key], value[key], f"{name}.{key}")
        elif isinstance(value, list):
            self.assertEqual(len(item), len(value), name)
            for one, other in zip(item, value):
                self.assert_same(one, other, name)
        else:
            self.assertEqual(item, value, name)

    def test_the_items_are_those_of_report_json(self):
        with open(os.path.join(self.box, "product-000001-nonsense"), "wb") as file:
            file.write(b"no product")
        server = self.serve_whole()
        state, report = server.state(), json.loads(server.get("/files/report.json")[2])
        report["files"] = [f for f in report["files"] if f["fault"] is not None]
        self.assertGreater(len(report["files"]), 0)
        for key, value in report.items():
            item = state[key]
            if isinstance(value, list) and value and isinstance(value[0], dict):
                self.assertEqual(item, [], key)
                self.assertEqual(len([n for n in state if n.startswith(key + "/")]), len(value), key)
                item = [state[f"{key}/{one.get('id', i)}"] for i, one in enumerate(value)]
            self.assert_same(item, value, key)
        self.assertEqual({n.split("/")[0] for n in state} - set(report), {"run", "figures", "results"})
        for keyframe in report["keyframes"]:
            for name in ("image", "depth", "mask"):
                status = server.get(f"/files/keyframes/{keyframe['id']:06d}-{name}.png")[0]
                self.assertEqual(status, 200 if name in keyframe["pictures"] else 404, (keyframe["id"], name))

    def test_no_other_file_can_be_read(self):
        server = self.serve_whole()
        secret = os.path.join(self.folder, "secret.txt")
        with open(secret, "w") as file:
            file.write("not for you")
        os.remove(os.path.join(self.out, "report.json"))
        os.symlink(secret, os.path.join(self.out, "report.json"))
        os.symlink(secret, os.path.join(self.out, "link.txt"))
        with open(os.path.join(self.out, "own.txt"), "w") as file:
            file.write("not for you")
        up = ["../secret.txt", "%2e%2e/secret.txt", "%2E%2E%2Fsecret.txt", "..%2fsecret.txt", "....//secret.txt",
              "keyframes/../../secret.txt", "%252e%252e/secret.txt", "..\\secret.txt", secret, "/" + secret,
              "/etc/passwd", "%2fetc%2fpasswd", "link.txt", "own.txt", "report.json", "", ".", "keyframes", "results.txt",
              "catalogue.db", "serve.lock", "%00/../../secret.txt", "file:///etc/passwd"]
        for path in ["/files/" + u for u in up] + ["/map/" + u for u in up] + ["/page/" + u for u in up] + ["//etc/passwd"]:
            status, headers, text = server.get(path)
            self.assertIn(status, (404, 503), path)
            self.assertTrue(headers["Content-Type"].startswith("text/plain"), path)
            self.assertTrue(text.startswith(str(status).encode()), path)
            self.assertNotIn(b"not for you", text)
        self.assertIn(b"plain file", server.get("/files/report.json")[2])

    def test_wrong_requests_are_answered_with_what_is_wrong(self):
        server = self.serve()
        for method in ("POST", "PUT", "DELETE", "OPTIONS", "PATCH"):
            status, headers, text = server.get("/state", method, body=b"x" * 100)
            self.assertEqual((status, headers["Allow"]), (405, "GET, HEAD"), method)
            self.assertIn(b"/state is for GET and HEAD", text)
        status, headers, text = server.get("/nothing<script>%07")
        self.assertEqual((status, headers["X-Content-Type-Options"]), (404, "nosniff"))
        self.assertTrue(headers["Content-Type"].startswith("text/plain"))
        self.assertEqual(server.get("/", "HEAD")[0], 200)
        self.assertEqual(server.get("/", "HEAD")[2], b"")

    def test_a_server_without_commands_has_no_way_to_give_one(self):
        server = self.serve()
        headers = {"Origin": "http://" + server.address, "Content-Type": "application/json", "Authorization": "Bearer x"}
        for path in ("/commands", "/reports", "/help", "/complete", "/page/commands.js"):
            self.assertEqual(server.get(path, headers=headers)[0], 404, path)
            status, allowed, _ = server.get(path, "POST", headers=headers, body='{"line":"ping"}')
            self.assertEqual((status, allowed["Allow"]), (405, "GET, HEAD"), path)
        self.assertNotIn("commands", server.state())

    def test_requests_too_large_or_broken_leave_it_at_work(self):
        server = self.serve()

        def send(octets):
            with socket.create_connection((server.host, server.port), timeout=patience_s) as peer:
                try:
                    peer.sendall(octets)
                    peer.shutdown(socket.SHUT_WR)
                    return peer.recv(100)
                except OSError:
                    return b""

        head = b"Host: " + server.address.encode() + b"\r\n"
        for octets in (b"GET /" + b"a" * 1000000 + b" HTTP/1.1\r\n" + head + b"\r\n",
                       b"GET / HTTP/1.1\r\n" + head + b"".join(b"X-%d: y\r\n" % i for i in range(100000)) + b"\r\n",
                       b"GET / HTTP/1.1\r\n" + head + b"X: " + b"y" * 1000000 + b"\r\n\r\n"):
            self.assertNotIn(b" 200 ", send(octets))
        for octets in (b"", b"\0" * 1000, b"\r\n\r\n", b"GET\r\n\r\n", os.urandom(5000), b"GET / HTTP/9.9\r\n\r\n",
                       b"POST / HTTP/1.1\r\n" + head + b"Content-Length: 99999999999999\r\n\r\n" + b"z" * 100000,
                       b"POST / HTTP/1.1\r\n" + head + b"Transfer-Encoding: chunked\r\n\r\nffffffffffffffff\r\n"):
            send(octets)
        self.assertEqual(server.get("/")[0], 200)
        self.assertIsNone(server.process.poll())

    def test_only_the_names_of_the_server_itself_are_answered(self):
        server = self.serve()
        paths = ("/", "/page/main.js", "/state", "/events", "/map/x", "/files/report.json", "/nothing")
        for host in foreign_hosts(server):
            for path in paths:
                status, _, text = server.get(path, headers={"Host": host})
                self.assertEqual(status, 403, (host, path))
            self.assertEqual(server.get("/state", "POST", headers={"Host": host}, body=b"x")[0], 403, host)
            self.assertIn(b"open http://" + server.address.encode(), text)
        for host in own_hosts(server):
            self.assertEqual(server.get("/", headers={"Host": host})[0], 200, host)
        # Where all addresses of the computer are served, it is the one at which the request came.
        other = os.path.join(self.folder, "everywhere")
        os.makedirs(other)
        everywhere = Server(ground, other, "--listen", "0.0.0.0:0")
        self.addCleanup(everywhere.end)
        for at, host, status in (("127.0.0.3", "127.0.0.3", 200), ("127.0.0.3", "localhost", 200),
                                 ("127.0.0.3", "127.0.0.4", 403), ("127.0.0.3", "evil.example", 403)):
            everywhere.host = at
            self.assertEqual(everywhere.get("/", headers={"Host": f"{host}:{everywhere.port}"})[0], status, (at, host))

    def test_the_server_of_open_mct_answers_to_its_own_names_too(self):
        node = shutil.which("node") or shutil.which("nodejs")
        if node is None:
            self.skipTest("no node")
        with open(os.path.join(self.folder, "openmct.js"), "w") as file:
            file.write("// stands for Open MCT\n")
        program = os.path.join(os.path.dirname(os.path.abspath(__file__)), "../../sim/tools/openmct/serve")
        beside = Server.__new__(Server)
        beside.process = subprocess.Popen([*with_the_test, node, program, "--flight", self.serve().address, "--listen", "127.0.0.1:0",
                                           "--openmct", self.folder], stdout=subprocess.PIPE, text=True)
        self.addCleanup(beside.end)
        beside.host, port = beside.process.stdout.readline().split("//")[1].strip().split(":")
        beside.port = int(port)
        for host in foreign_hosts(beside):
            for path in ("/", "/state", "/plugin.js"):
                self.assertEqual(beside.get(path, headers={"Host": host})[0], 403, (host, path))
        for host in own_hosts(beside):
            self.assertEqual(beside.get("/state", headers={"Host": host})[0], 200, host)

    def test_a_new_page_takes_the_place_of_the_oldest_one(self):
        server = self.serve()
        streams = [Stream(server) for _ in range(64)]
        self.assertEqual(server.get("/")[0], 200)
        for _ in range(8):
            streams.append(Stream(server))
            self.assertEqual(server.get("/state")[0], 200)
        wait_for("the end of the oldest page", lambda: not streams[0].thread.is_alive())
        wait_for("the newest page to be alive", lambda: streams[-1].alive > 0)
        for stream in streams:
            stream.close()
        self.assertEqual(server.get("/")[0], 200)

    def test_connections_that_say_nothing_or_little_keep_nobody_out(self):
        server = self.serve()
        page = Stream(server)
        slow = SlowConnections(server, [b"GET /", b"GET / HTTP/1.1\r\nX-Never: "])
        for _ in range(8):
            slow.open(30)
            slow.drip()
            self.assertEqual(server.get("/state")[0], 200)
        wait_for("the end of all slow connections, however often they say something", lambda: slow.drip() == 0)
        self.assertTrue(page.thread.is_alive(), "a page that listens gives way to nobody who has asked for nothing")

    def test_a_flood_of_connections_lets_a_reader_through(self):
        server = self.serve()
        flood = Flood(server)
        self.addCleanup(flood.end)

        def answers():
            try:
                return server.get("/")[0] == 200
            except (OSError, http.client.HTTPException):
                return False

        while flood.made < 500:
            wait_for("an answer amid the flood", answers)
        flood.end()

    def test_a_silent_flight_keeps_the_stream_alive(self):
        stream = Stream(self.serve())
        wait_for("two signs of life", lambda: stream.alive >= 2)

    def refused(self, *arguments):
        run = subprocess.run([ground, "serve", *arguments], capture_output=True, text=True, timeout=patience_s)
        self.assertEqual(run.returncode, 1, run.stderr)
        return run.stderr

    def test_a_start_that_cannot_be_says_what_to_do(self):
        server = self.serve()
        other = os.path.join(self.folder, "other")
        os.makedirs(other)
        message = self.refused(other, "--listen", server.address)
        self.assertIn("another program uses this port", message)
        self.assertIn("--listen", message)
        self.assertIn("another ilp-ground serve works in", self.refused(self.box, "--listen", "127.0.0.1:0"))
        self.assertIn("is no folder", self.refused(os.path.join(self.folder, "absent")))
        self.assertIn("not 8080", self.refused(other, "--listen", "8080"))
        self.assertIn("address of this computer", self.refused(other, "--listen", "192.0.2.1:8080"))

    def test_the_folder_of_a_flight_names_its_outbox(self):
        outbox = os.path.join(self.box, "outbox")
        os.makedirs(outbox)
        deliver(source, outbox, os.listdir(source))
        server = self.serve()
        wait_for("the flight", lambda: len([n for n in server.state() if n.startswith("keyframes/")]) == keyframes)
        self.assertTrue(os.path.exists(os.path.join(self.box, "ground", "report.html")))


if __name__ == "__main__":
    shutil.rmtree(source, ignore_errors=True)
    os.makedirs(work, exist_ok=True)
    subprocess.run([make_downlink, source, str(keyframes), "1", "160", "120"], check=True)
    run_side_by_side(Serve, sys.argv[4:])
