// Measures on the emulated board how long the flight software takes to answer a ping (service 17), in the board's time:
// pinger ADDRESS PORT PERIOD_MS
//
// It stands for the world outside, so it has priority over everything else. One ping is on its way at a time. Where one
// has taken longer than all before, and after every hundred, it prints the number of pings and the longest time.

#include <arpa/inet.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <sched.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <cstdio>
#include <cstdlib>
#include <cstring>

#include "bsp/emulated-board/programs/readiness.hpp"
#include "fsw/packets/pus.hpp"

namespace {

constexpr int priority = 80;
constexpr std::uint16_t apid = 239;   // the default of the mission
constexpr std::uint16_t source = 77;  // answers come to this destination
constexpr std::uint8_t test_service = 17, are_you_alive = 1, i_am_alive = 2;
constexpr double patience_s = 10;
constexpr double pause_s = 0.2;

int open_link(const char* address, const char* port) {
  sockaddr_in to{};
  to.sin_family = AF_INET;
  to.sin_port = htons(static_cast<std::uint16_t>(std::strtol(port, nullptr, 10)));
  inet_pton(AF_INET, address, &to.sin_addr);
  for (;;) {
    const int link = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
    if (connect(link, reinterpret_cast<const sockaddr*>(&to), sizeof(to)) == 0) {
      const int on = 1;
      setsockopt(link, IPPROTO_TCP, TCP_NODELAY, &on, sizeof(on));
      return link;
    }
    close(link);
    board::sleep_until(board::uptime_s() + pause_s);
  }
}

bool send_ping(int link, std::uint16_t count) {
  ilp::Telecommand ping;
  ping.primary.telecommand = true;
  ping.primary.apid = apid;
  ping.primary.sequence_count = count;
  ping.ack_flags = 0;
  ping.service = test_service;
  ping.subtype = are_you_alive;
  ping.source = source;
  std::array<std::uint8_t, ilp::telecommand_overhead_bytes> packet{};
  std::size_t bytes = 0;
  if (!ilp::encode_telecommand(ping, packet, bytes).ok()) return false;
  return write(link, packet.data(), bytes) == static_cast<ssize_t>(bytes);
}

bool read_all(int link, std::uint8_t* to, std::size_t bytes, double until) {
  while (bytes > 0) {
    pollfd wait{link, POLLIN, 0};
    const double left_s = until - board::uptime_s();
    if (left_s <= 0 || poll(&wait, 1, static_cast<int>(1000 * left_s) + 1) < 0) return false;
    if (wait.revents == 0) continue;
    const ssize_t got = read(link, to, bytes);
    if (got <= 0) return false;
    to += got;
    bytes -= static_cast<std::size_t>(got);
  }
  return true;
}

/// Reads telemetry up to the answer. Reads also what is for others, so that the link does not fill up.
bool wait_for_answer(int link, double until) {
  std::array<std::uint8_t, 65536 + ilp::primary_header_bytes> packet{};
  for (;;) {
    if (!read_all(link, packet.data(), ilp::primary_header_bytes, until)) return false;
    const std::size_t rest = std::size_t{256} * packet[4] + packet[5] + 1;
    if (!read_all(link, packet.data() + ilp::primary_header_bytes, rest, until)) return false;
    const std::uint8_t* const head = packet.data() + ilp::primary_header_bytes;
    if (rest < ilp::telemetry_header_bytes) continue;
    const int destination = 256 * head[5] + head[6];
    if (head[1] == test_service && head[2] == i_am_alive && destination == source) return true;
  }
}

}  // namespace

int main(int count, char** words) {
  if (count != 4) {
    std::fputs("usage: pinger ADDRESS PORT PERIOD_MS\n", stderr);
    return 2;
  }
  sched_param parameters{};
  parameters.sched_priority = priority;
  sched_setscheduler(0, SCHED_FIFO, &parameters);
  board::say_ready();
  const double period_s = 1e-3 * std::strtod(words[3], nullptr);
  double longest_s = 0;
  int pings = 0, lost = 0;
  int link = open_link(words[1], words[2]);
  for (std::uint16_t number = 0;; number = static_cast<std::uint16_t>((number + 1) % ilp::sequence_counts)) {
    const double begin = board::uptime_s();
    const bool answered = send_ping(link, number) && wait_for_answer(link, begin + patience_s);
    const double took_s = board::uptime_s() - begin;
    ++pings;
    lost += answered ? 0 : 1;
    if (!answered) {
      close(link);
      link = open_link(words[1], words[2]);
    }
    if (answered && took_s > longest_s) longest_s = took_s;
    if (!answered || took_s >= longest_s || pings % 100 == 0) {
      std::printf("pings %d lost %d longest_ms %.1f at %.1f\n", pings, lost, 1e3 * longest_s, begin);
    }
    board::sleep_until(begin + period_s);
  }
}
