#!/usr/bin/env python3
"""What a client of a server with commands sees, with a flight in real time behind it:
command_test.py ILP_SIL ILP_GROUND WORK [TEST...]"""
import http.client
import json
import os
import shutil
import socket
import stat
import subprocess
import sys
import unittest

from flight import Flight
from served import (Flood, Server, SlowConnections, foreign_hosts, own_hosts, patience_s, run_side_by_side, wait_for,
                    with_the_test)

sil, ground, work = sys.argv[1:4]
token = "only-for-this-test-7c1f9a"
key = "000102030405060708090a0b0c0d0e0f101112131415161718191a1b1c1d1e1f"


def write_private(path, text):
    with open(os.open(path, os.O_WRONLY | os.O_CREAT | os.O_TRUNC, 0o600), "w") as file:
        file.write(text)
    return path


class CommandServer(Server):
    """A server that takes commands; its standard error goes to a file."""

    def __init__(self, box, address, *options, environment=None):
        self.errors = box + ".err"
        with open(self.errors, "w") as errors:
            super().__init__(ground, box, "--listen", "127.0.0.1:0", "--commands", address, *options, stderr=errors, env=environment)
        self.process.stdout.readline()
        assert self.process.stdout.readline() == f"Commands go to the flight at {address}\n"
        self.place, self.lines, self.panel = "", [], []

    def headers(self, **changed):
        headers = {"Authorization": "Bearer " + token, "Origin": "http://" + self.address,
                   "Content-Type": "application/json"}
        for name, value in changed.items():
            name = name.replace("_", "-")
            headers.pop(name, None)
            if value is not None:
                headers[name] = value
        return headers

    def post(self, body, path="/commands", **changed):
        status, headers, text = self.get(path, "POST", self.headers(**changed), body)
        return status, headers, text.decode()

    def command(self, line, **changed):
        return self.post(json.dumps({"line": line}), **changed)

    def listen(self):
        status, _, text = self.get("/reports?after=" + self.place, headers=self.headers())
        assert status == 200, text
        answer = json.loads(text)
        if answer["full"]:
            self.lines = []
        self.lines += [line for _, line in answer["lines"]]
        self.place, self.panel, self.waiting = answer["place"], answer["panel"], answer["waiting"]
        return self.lines

    def hears(self, line):
        wait_for(f"the report '{line}'; there were {self.lines}", lambda: any(line in one for one in self.listen()))


class Commands(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        shutil.rmtree(work, ignore_errors=True)
        os.makedirs(work)
        cls.token_file = write_private(os.path.join(work, "token"), token + "\n")

    def setUp(self):
        self.folder = os.path.join(work, self.id().rsplit(".", 1)[1])
        os.makedirs(self.folder)

    def fly(self, *options, **more):
        """A flight answers one operator over UDP, so each test has its own."""
        flight = Flight(sil, os.path.join(self.folder, "flown"), *options, **more)
        self.addCleanup(flight.end)
        return flight

    def box(self):
        box = os.path.join(self.folder, "box")
        os.makedirs(box)
        return box

    def serve(self, *options, address=None, environment=None, token_file=True):
        chosen = ["--token-file", self.token_file] if token_file else []
        server = CommandServer(self.box(), address or self.fly().address, *chosen, *options, environment=environment)
        self.addCleanup(server.end)
        return server

    def test_a_command_is_carried_out_and_its_reports_come(self):
        server = self.serve()
        self.assertEqual(server.command("ping")[0], 200)
        for report in ("accepted: ping", "the flight is alive", "done: ping"):
            server.hears(report)
        self.assertEqual(json.loads(server.command("  set   overlap.target_overlap  0.9 ")[2]),
                         {"line": "set overlap.target_overlap 0.9"})
        server.hears("done: set overlap.target_overlap 0.9")
        # The flight itself says what it has been set to.
        self.assertEqual(server.command("get overlap.target_overlap")[0], 200)
        server.hears("overlap.target_overlap = 0.9")
        self.assertEqual(server.command("capture +1")[0], 200)
        server.hears("done: capture +1")
        wait_for("housekeeping", lambda: server.listen() and any("1 frames" in line for line in server.panel))
        wait_for("no command that waits", lambda: server.listen() and server.waiting == [])
        # The flight refuses what only it can know.
        self.assertEqual(server.command("delete 4000000 depth")[0], 200)
        server.hears("failed: delete 4000000 depth")

    def test_a_line_that_cannot_be_sent_says_why(self):
        server = self.serve()
        for line, why in (("launch", "there is no command launch"),
                          ("set overlap.target_overlap 1.5", "not a number from 0.5 to 0.98"),
                          ("set overlap.nothing 1", "no parameter overlap.nothing"),
                          ("set", "it is written: set SECTION.KEY VALUE"),
                          ("call SELFDESTRUCT", "a function is one of"),
                          ("series +1 0.1 70000", "the number of images"),
                          ("uplink /etc/passwd", "reads no file of the computer"),
                          ("quit", "for scripts"), ("wait 1000000", "for scripts"), ("", "empty")):
            status, _, text = server.command(line)
            self.assertEqual(status, 422, (line, text))
            self.assertIn(why, text)
        for body in ("", "ping", "[]", "{}", '{"line":1}', '{"line":"ping","line2":"x"}', '{"line":"ping\\nping"}',
                     '{"line":"p\\u00efng"}', "{" * 1000, '{"line":"ping"', "\0\0"):
            self.assertEqual(server.post(body)[0], 400, body)
        self.assertEqual(server.get("/nothing", headers=server.headers())[0], 404)
        self.assertFalse(any("sent:" in line for line in server.listen()))

    def test_nothing_goes_without_the_token(self):
        server = self.serve()
        for path in ("/reports", "/help", "/complete?typed=c", "/commands"):
            self.assertEqual(server.get(path)[0], 401, path)
        self.assertEqual(server.get("/reports?token=" + token)[0], 401)
        self.assertEqual(server.command("ping", Authorization=None)[0], 401)
        self.assertEqual(server.command("ping", Authorization="Basic " + token)[0], 401)
        for wrong in ("", "x", token[:-1], token + "x", token.upper(), "x" * 5000):
            status, headers, text = server.command("ping", Authorization="Bearer " + wrong)
            # libmicrohttpd 1.0 takes blanks off the end of a header: what is left names no token.
            self.assertIn(status, (401, 403) if wrong == "" else (403,), wrong)
            self.assertNotIn(token, text)
        self.assertEqual(server.command("ping")[0], 200)
        server.hears("done: ping")
        self.assertEqual(sum(line == "sent: ping" for line in server.lines), 1)
        self.assertTrue(any("a wrong token came from 127.0.0.1" in line for line in server.lines))
        self.assertIn("a wrong token came from 127.0.0.1", open(server.errors).read())

    def test_wrong_tokens_never_shut_out_the_right_one(self):
        server = self.serve()
        for i in range(200):
            self.assertEqual(server.command("ping", Authorization="Bearer guess-%d" % i)[0], 403)
            if i % 20 == 0:
                self.assertEqual(server.command("ping")[0], 200, i)
        self.assertEqual(server.command("ping")[0], 200)
        server.hears("done: ping")
        # The operator is told, and not flooded: 500 lines are kept in all.
        told = [line for line in server.listen() if "a wrong token came from 127.0.0.1" in line]
        self.assertTrue(1 <= len(told) <= 20, told)

    def test_slow_connections_keep_nobody_out_and_have_a_deadline(self):
        server = self.serve()
        kept = http.client.HTTPConnection(server.address, timeout=patience_s)

        def on_the_kept_connection():
            kept.request("GET", "/help", headers=server.headers())
            answer = kept.getresponse()
            answer.read()
            return answer.status

        self.assertEqual(on_the_kept_connection(), 200)
        slow = SlowConnections(server, [b"GET / HTTP/1.1\r\nHost: " + server.address.encode() + b"\r\n",
                                        b"POST /commands HTTP/1.1\r\nX-Never: "])
        for _ in range(8):
            slow.open(30)
            slow.drip()
            # A right token keeps its connection, and has a new one whenever it asks for one.
            self.assertEqual(on_the_kept_connection(), 200)
            self.assertEqual(server.command("ping")[0], 200)
        kept.close()
        wait_for("the end of all slow connections, however often they say something", lambda: slow.drip() == 0)
        server.hears("done: ping")

    def test_a_flood_of_connections_lets_the_operator_through(self):
        server = self.serve()
        flood = Flood(server)
        self.addCleanup(flood.end)

        def commanded():
            try:
                return server.command("ping")[0] == 200
            except (OSError, http.client.HTTPException):
                return False

        while flood.made < 500:
            wait_for("a command amid the flood", commanded)
        flood.end()
        server.hears("done: ping")

    def test_a_page_of_another_site_commands_nothing(self):
        server = self.serve()
        for origin in (None, "null", "http://evil.example", "http://127.0.0.1:1", "https://" + server.address,
                       "http://" + server.address + ".evil.example"):
            status, _, text = server.command("ping", Origin=origin)
            self.assertEqual(status, 403, origin)
            self.assertIn("Origin", text)
        # A name that leads here (DNS rebinding) has its own origin.
        for host in foreign_hosts(server):
            self.assertEqual(server.command("ping", Host=host, Origin="http://" + host)[0], 403, host)
            for path in ("/", "/page/commands.js", "/reports", "/help", "/complete?typed=c", "/nothing"):
                status, _, text = server.get(path, headers=server.headers(Host=host))
                self.assertEqual(status, 403, (host, path))
                self.assertIn(b"open http://" + server.address.encode(), text)
        for host in own_hosts(server):
            self.assertEqual(server.command("ping", Host=host, Origin="http://" + host)[0], 200, host)
        self.assertEqual(server.command("get overlap.target_overlap", Host="evil.example", Origin="http://evil.example")[0], 403)
        # What a form or an image of another site can send without asking has no token, and no such type.
        for kind in ("text/plain", "application/x-www-form-urlencoded", "multipart/form-data", None):
            self.assertEqual(server.command("ping", Content_Type=kind)[0], 415)
        status, headers, _ = server.get("/commands", "OPTIONS", {"Origin": "http://evil.example",
                                                                 "Access-Control-Request-Method": "POST"})
        self.assertEqual(status, 405)
        for path in ("/", "/reports", "/help"):
            headers = server.get(path, headers=server.headers())[1]
            self.assertNotIn("Set-Cookie", headers)
            self.assertNotIn("Access-Control-Allow-Origin", headers)
        self.assertIn("frame-ancestors 'none'", server.get("/")[1]["Content-Security-Policy"])
        # Only the hosts of its own were heard.
        self.assertEqual(sum(line == "sent: ping" for line in server.listen()), len(own_hosts(server)))
        self.assertFalse(any("sent: get" in line for line in server.lines))

    def test_bodies_are_bounded(self):
        server = self.serve()
        self.assertEqual(server.post(json.dumps({"line": "x" * 2000}))[0], 422)
        self.assertEqual(server.post("x" * 2049)[0], 413)

        def send(octets, more=True):
            with socket.create_connection((server.host, server.port), timeout=patience_s) as peer:
                try:
                    peer.sendall(octets)
                    if not more:
                        peer.shutdown(socket.SHUT_WR)
                    return peer.recv(100)
                except OSError:
                    return b""

        head = "".join(f"{name}: {value}\r\n" for name, value in server.headers(Host=server.address).items())
        start = f"POST /commands HTTP/1.1\r\n{head}".encode()
        self.assertIn(b" 413 ", send(start + b"Content-Length: 99999999999\r\n\r\n"))
        self.assertIn(b" 413 ", send(start + b"Content-Length: 99999999999999999999999\r\n\r\n"))
        self.assertIn(b" 411 ", send(start + b"Transfer-Encoding: chunked\r\n\r\n"))
        for octets in (start + b"Content-Length: 10000000\r\n\r\n" + b"x" * 10000000,
                       start + b"Transfer-Encoding: chunked\r\n\r\n" + b"ffff\r\n" + b"x" * 65535,
                       start + b"X: " + b"y" * 1000000 + b"\r\n\r\n", os.urandom(4000), b"\0" * 4000):
            send(octets, more=False)
        # A body that never comes to its end keeps no other client away.
        idle = socket.create_connection((server.host, server.port), timeout=patience_s)
        idle.sendall(start + b"Content-Length: 100\r\n\r\n{")
        self.assertEqual(server.command("ping")[0], 200)
        idle.close()
        server.hears("done: ping")
        self.assertIsNone(server.process.poll())

    def test_the_page_has_a_panel_and_one_path_takes_commands(self):
        server = self.serve()
        self.assertIs(server.state()["commands"], True)
        self.assertEqual(server.get("/page/commands.js")[0], 200)
        self.assertEqual(server.get("/commands", headers=server.headers())[0], 405)
        for path in ("/", "/state", "/events", "/reports", "/help", "/files/report.json", "/page/commands.js", "/commands/"):
            self.assertEqual(server.post('{"line":"ping"}', path)[0], 405, path)
        self.assertFalse(any("sent:" in line for line in server.listen()))

    def test_the_token_is_nowhere_to_be_read(self):
        environment = {**os.environ, "ILP_COMMAND_TOKEN": token}
        server = self.serve(environment=environment, token_file=False)
        self.assertEqual(server.command("ping")[0], 200)
        server.command("ping", Authorization="Bearer " + "w" * 30)
        with open(f"/proc/{server.process.pid}/cmdline") as arguments:
            self.assertNotIn(token, arguments.read())
        server.hears("done: ping")
        self.assertNotIn(token, "".join(server.lines))
        log = open(server.errors).read()
        self.assertNotIn(token, log)
        self.assertNotIn("w" * 30, log)

    def test_a_flight_with_keys_is_commanded_with_one(self):
        keys = write_private(os.path.join(work, "keys"), f"5 {key}\n6 {key[::-1]}\n")
        flight = self.fly("--key", keys, mission_lines="[link]\nauthentication = 1\n")
        server = self.serve("--key", keys, "--spi", "6", address=flight.address)
        self.assertEqual(server.command("ping")[0], 200)
        server.hears("done: ping")
        os.makedirs(os.path.join(self.folder, "bare"))
        bare = CommandServer(os.path.join(self.folder, "bare"), flight.address, "--token-file", self.token_file, "--source", "7")
        self.addCleanup(bare.end)
        self.assertEqual(bare.command("ping")[0], 200)
        bare.hears("no answer yet: ping")
        self.assertFalse(any("done: ping" in line for line in bare.lines))

    def test_a_flight_that_comes_later_is_found(self):
        with socket.socket(socket.AF_INET, socket.SOCK_STREAM) as probe:
            probe.bind(("127.0.0.1", 0))
            address = "127.0.0.1:%d" % probe.getsockname()[1]
        server = self.serve("--tcp", address=address)
        server.hears("the flight cannot be reached")
        status, _, text = server.command("ping")
        self.assertEqual(status, 503)
        self.assertIn("the flight cannot be reached", text)
        self.fly("--link-tcp", address)
        wait_for("the flight", lambda: server.command("ping")[0] == 200)
        server.hears("done: ping")

    def refused(self, *options, listen="127.0.0.1:0", environment=None):
        box = os.path.join(self.folder, "refused")
        os.makedirs(box, exist_ok=True)
        run = subprocess.run([ground, "serve", box, "--listen", listen, *options], capture_output=True, text=True,
                             timeout=patience_s, env=environment)
        self.assertEqual(run.returncode, 1, run.stderr)
        self.assertNotIn(token, run.stderr)
        return run.stderr

    def test_a_panel_that_would_not_be_safe_does_not_start(self):
        link, file = ("--commands", "127.0.0.1:10025"), ("--token-file", self.token_file)
        self.assertIn("an address is written", self.refused("--commands", "10025", *file))
        self.assertIn("commands need a token", self.refused(*link))
        self.assertIn("say where the flight listens", self.refused(*file))
        self.assertIn("say where the flight listens", self.refused("--commands-from-other-computers"))
        for everywhere in ("0.0.0.0:0", "192.0.2.1:0"):
            self.assertIn("--commands-from-other-computers", self.refused(*link, *file, listen=everywhere))
        loose = write_private(os.path.join(work, "loose"), token)
        os.chmod(loose, stat.S_IRUSR | stat.S_IWUSR | stat.S_IRGRP)
        self.assertIn("chmod 600", self.refused(*link, "--token-file", loose))
        for bad in ("short", "with blanks in the middle", "", "x" * 257, "t\u00f6ken-with-umlaut-123"):
            weak = write_private(os.path.join(work, "weak"), bad + "\n")
            self.assertIn("16 to 256 printable", self.refused(*link, "--token-file", weak))
            self.assertIn("16 to 256 printable",
                          self.refused(*link, environment={**os.environ, "ILP_COMMAND_TOKEN": bad}))
        self.assertIn("cannot read the token file", self.refused(*link, "--token-file", work + "/none"))
        self.assertIn("no plain file", self.refused(*link, "--token-file", work))
        usage = subprocess.run([ground, "serve", work, "--token", token], capture_output=True, text=True)
        self.assertEqual(usage.returncode, 2, "a token is never an argument")


if __name__ == "__main__":
    run_side_by_side(Commands, sys.argv[4:])
