// Runs the operator's console for the page's panel of commands: a thread that owns the console, a log of the console's
// lines, and a queue of commands.
#pragma once

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <deque>
#include <future>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "sim/ground/console/operator_console.hpp"
#include "sim/ground/serve/state_log.hpp"

namespace ilp::serve {

class CommandQueue {
 public:
  enum class Outcome : std::uint8_t { done, refused, unavailable };
  struct Answer {
    Outcome outcome = Outcome::done;
    std::string text;  ///< the command as parsed if it was sent, else why it was not sent
  };

  /// Starts the thread, which connects to the flight; if that fails, it tries again every 5 s.
  explicit CommandQueue(console::OperatorSettings settings);
  ~CommandQueue();
  CommandQueue(const CommandQueue&) = delete;
  CommandQueue& operator=(const CommandQueue&) = delete;

  /// Executes a line as typed into ilp-ground console, and waits until it is sent or refused. Refuses commands for the
  /// console itself (wait, quit) and for files of this computer (uplink).
  [[nodiscard]] Answer enter(const std::string& line);
  /// Adds a line to the log of all pages.
  void say(const std::string& text);
  /// The changes since `place` as JSON: {"place":TEXT,"full":BOOL,"lines":[[UTC_MS,TEXT]],"panel":[TEXT],
  /// "waiting":[TEXT]}. Returns everything (the latest 500 lines) at once if `place` is none or of another process;
  /// otherwise waits for a change, at most for `longest`.
  [[nodiscard]] std::string reports(const std::optional<Place>& place, std::chrono::milliseconds longest) const;
  /// Ends all present and future waits.
  void end();

 private:
  struct Line {
    std::uint64_t version = 0;
    std::int64_t utc_ms = 0;
    std::string text;
  };
  struct Order {
    std::string line;
    std::promise<Answer> answer;
  };
  void run();
  void operate(console::OperatorConsole& console);
  void answer_orders(console::OperatorConsole* console, const std::string& problem);
  void show(const console::OperatorConsole& console);

  console::OperatorSettings settings_;
  std::atomic<bool> ending_ = false;
  mutable std::mutex mutex_;
  mutable std::condition_variable changed_;
  Place newest_;
  std::deque<Line> lines_;
  std::deque<Order> orders_;
  std::vector<std::string> panel_, waiting_;
  std::thread thread_;
};

}  // namespace ilp::serve
