// The operator's console behind the panel of commands: a thread that owns it, the lines that it has said, and the
// orders that wait for it.
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
    std::string text;  ///< the line as it was understood, or why nothing was sent
  };

  /// Begins at once; a flight that cannot be reached is tried again every 5 s.
  explicit CommandQueue(console::OperatorSettings settings);
  ~CommandQueue();
  CommandQueue(const CommandQueue&) = delete;
  CommandQueue& operator=(const CommandQueue&) = delete;

  /// A line as it is typed into ilp-ground console. What concerns the console itself (wait, quit) or files of this
  /// computer (uplink) is refused. Waits until it is sent or refused.
  [[nodiscard]] Answer enter(const std::string& line);
  /// A line for all pages.
  void say(const std::string& text);
  /// What is new since `place`, as JSON: {"place":TEXT,"full":BOOL,"lines":[[UTC_MS,TEXT]],"panel":[TEXT],
  /// "waiting":[TEXT]}; everything that is kept (the latest 500 lines) if it is none or of another process. Waits until
  /// there is something new, at most for `longest`.
  [[nodiscard]] std::string reports(const std::optional<Place>& place, std::chrono::milliseconds longest) const;
  /// All waiting threads return, and no thread waits any more.
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
