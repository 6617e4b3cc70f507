#include "sim/ground/console/console_main.hpp"
#include "sim/host/command_line.hpp"

#include <poll.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <array>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <iostream>
#include <optional>
#include <stdexcept>

#include "hal/clock/utc.hpp"
#include "sim/ground/console/link_options.hpp"
#include "sim/ground/console/operator_console.hpp"
#include "sim/ground/console/terminal.hpp"
#include "sim/ground/console/utc_text.hpp"

namespace ilp::console {
namespace {

constexpr double turn_s = 0.1;
/// How long the console waits for the last reports of a script's telecommands.
constexpr double patience_s = 60;

volatile std::sig_atomic_t asked_to_end = 0;

void end_soon(int) {
  asked_to_end = 1;
}

struct Options {
  LinkOptions link;
  std::string out;
  bool plain = false;
  double every_s = 2, status_s = 10, stay_s = 0, patience_s = 60;
};

OperatorSettings settings_of(const Options& options) {
  OperatorSettings settings = operator_settings(options.link);
  settings.out = options.out;
  settings.interval = static_cast<TimeNs>(options.every_s * 1e9);
  return settings;
}

// The lines of a pipe or a file that have arrived so far.
class PipedLines {
 public:
  std::optional<std::string> next() {
    std::array<char, 4096> buffer{};
    pollfd wait{STDIN_FILENO, POLLIN, 0};
    while (!ended_ && ::poll(&wait, 1, 0) == 1) {
      const ssize_t size = ::read(STDIN_FILENO, buffer.data(), buffer.size());
      if (size <= 0) {
        ended_ = true;
      } else {
        text_.append(buffer.data(), static_cast<std::size_t>(size));
      }
    }
    const std::size_t end = text_.find('\n');
    if (end == std::string::npos && !(ended_ && !text_.empty())) return std::nullopt;
    std::string line = text_.substr(0, end);
    text_.erase(0, end == std::string::npos ? end : end + 1);
    return line;
  }
  [[nodiscard]] bool ended() const { return ended_ && text_.empty(); }

 private:
  std::string text_;
  bool ended_ = false;
};

void print(const std::string& line) {
  std::cout << clock_text(utc_now()) << " " << fit(line, line.size()) << std::endl;
}

// A script's commands are sent only when the flight listens.
bool wait_for_flight(OperatorConsole& console, const Options& options) {
  const double begin = now_s();
  while (asked_to_end == 0 && !console.closed() && !console.view().reports.of("status")) {
    if (now_s() - begin > options.patience_s) return false;
    console.step(turn_s);
  }
  return true;
}

int run_piped(const Options& options) {
  OperatorConsole console(settings_of(options), print);
  PipedLines lines;
  if (!wait_for_flight(console, options))
    throw std::runtime_error("no report comes from the flight at " + options.link.address + ": " +
                             console.silence_words());
  const double begin = now_s();
  double pause_until = 0, last_line = begin, reported = begin;
  while (asked_to_end == 0 && !console.wants_to_quit() && !console.closed()) {
    const double now = now_s();
    if (now >= pause_until) {
      if (const std::optional<std::string> line = lines.next()) {
        console.enter(*line);
        last_line = now;
        pause_until = now + console.pause_s();
        continue;
      }
      const bool done = console.waiting().empty() || now - last_line > patience_s;
      if (lines.ended() && done && now - begin >= options.stay_s) break;
    }
    console.step(turn_s);
    if (options.status_s <= 0 || now - reported < options.status_s) continue;
    reported = now;
    print("status: " + status_line(console.view()));
  }
  if (console.closed()) print("the flight has closed the connection");
  const std::vector<std::string> waiting = console.waiting();
  for (const std::string& words : waiting) print("no last report has come: " + words);
  return console.failures() + waiting.size() > 0 || console.closed() ? 1 : 0;
}

int run_in_terminal(const Options& options) {
  const OperatorSettings settings = settings_of(options);
  Terminal terminal(complete_operator_line);
  OperatorConsole console(settings, [&](const std::string& line) { terminal.say(clock_text(utc_now()) + " " + line); });
  terminal.say("Type help for the commands, quit to leave. Tab completes, the arrow keys recall earlier lines.");
  bool ended = false;
  while (asked_to_end == 0 && !ended && !console.wants_to_quit() && !console.closed()) {
    if (const std::optional<std::string> line = terminal.read_line(ended)) console.enter(*line);
    console.step(turn_s);
    terminal.draw(panel(console.view()));
  }
  return console.closed() ? 1 : 0;
}

}  // namespace

int console_main(int argc, char** argv) {
  host::CommandLine app(
      "ilp-ground console",
      "Operates a flight over its link: shows housekeeping and events, receives files, sends commands",
      "ilp-ground console 127.0.0.1:10025 --out received",
      "Exit status: 0 done, 1 the work could not be done, or a command failed, 2 wrong call");
  Options options;
  app.add_option("address", options.link.address, "ADDRESS:PORT at which the flight listens (docs/links.md)")
      ->required();
  app.add_option("--out", options.out, "folder for files that come down; without it this station receives none");
  app.add_option("--every", options.every_s, "seconds between housekeeping reports")->check(CLI::Range(0.1, 3600.0));
  app.add_flag("--plain", options.plain, "print lines only, in a terminal too");
  app.add_option("--status", options.status_s, "seconds between status lines when not in a terminal; 0: none");
  app.add_option("--stay", options.stay_s,
                 "least time in seconds for which the console stays when its input is a pipe");
  app.add_option("--patience", options.patience_s,
                 "longest time in seconds for which a script waits for the first report of the flight")
      ->check(CLI::Range(0.1, 1e6));
  add_link_options(app, options.link);
  add_file_link_options(app, options.link);
  if (const auto end = ilp::host::read_command_line(app, argc, argv)) return *end;
  std::signal(SIGINT, end_soon);
  std::signal(SIGTERM, end_soon);
  try {
    const bool terminal = !options.plain && ::isatty(STDIN_FILENO) != 0 && ::isatty(STDOUT_FILENO) != 0;
    return terminal ? run_in_terminal(options) : run_piped(options);
  } catch (const std::exception& error) {
    std::cerr << "ilp-ground console: " << error.what() << "\n";
    return 1;
  }
}

}  // namespace ilp::console
