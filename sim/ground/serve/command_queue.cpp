#include "sim/ground/serve/command_queue.hpp"

#include <nlohmann/json.hpp>
#include <random>
#include <stdexcept>
#include <utility>

#include "sim/ground/console/flight_view.hpp"

namespace ilp::serve {
namespace {

constexpr std::size_t most_lines = 500, most_orders = 16;
constexpr double turn_s = 0.1;
constexpr std::chrono::seconds patience{5};

using console::OperatorCommand;

// Empty for what the page may send.
std::string why_not_here(const OperatorCommand& command) {
  switch (command.kind) {
    case OperatorCommand::Kind::uplink:
      return "a file is sent with ilp-ground console: this page reads no file of the computer";
    case OperatorCommand::Kind::wait:
    case OperatorCommand::Kind::quit:
      return "it is for scripts of ilp-ground console";
    case OperatorCommand::Kind::nothing:
      return "the line is empty";
    default:
      return "";
  }
}

CommandQueue::Answer answer_of(console::OperatorConsole& console, const std::string& line) {
  try {
    const OperatorCommand command = console.parse(line);
    const std::string why_not = why_not_here(command);
    if (!why_not.empty()) return {CommandQueue::Outcome::refused, why_not};
    console.execute(command);
    return {CommandQueue::Outcome::done, command.words};
  } catch (const std::runtime_error& error) {
    return {CommandQueue::Outcome::refused, error.what()};
  }
}

}  // namespace

CommandQueue::CommandQueue(console::OperatorSettings settings) : settings_(std::move(settings)) {
  std::random_device random;
  newest_.process = std::uint64_t{random()} << 32U | random();
  thread_ = std::thread([this] { run(); });
}

CommandQueue::~CommandQueue() {
  end();
  thread_.join();
}

void CommandQueue::end() {
  ending_ = true;
  const std::lock_guard lock(mutex_);
  changed_.notify_all();
}

void CommandQueue::say(const std::string& text) {
  const auto now = std::chrono::system_clock::now().time_since_epoch();
  const std::lock_guard lock(mutex_);
  lines_.push_back({++newest_.version, std::chrono::duration_cast<std::chrono::milliseconds>(now).count(), text});
  if (lines_.size() > most_lines) lines_.pop_front();
  changed_.notify_all();
}

CommandQueue::Answer CommandQueue::enter(const std::string& line) {
  std::future<Answer> answer;
  {
    const std::lock_guard lock(mutex_);
    if (ending_ || orders_.size() >= most_orders) {
      return {Outcome::unavailable, "too many commands wait to be sent; try again in a second"};
    }
    orders_.push_back({line, {}});
    answer = orders_.back().answer.get_future();
  }
  return answer.get();
}

void CommandQueue::answer_orders(console::OperatorConsole* console, const std::string& problem) {
  while (true) {
    Order order;
    {
      const std::lock_guard lock(mutex_);
      if (orders_.empty()) return;
      order = std::move(orders_.front());
      orders_.pop_front();
    }
    order.answer.set_value(console != nullptr ? answer_of(*console, order.line)
                                              : Answer{Outcome::unavailable, problem});
  }
}

void CommandQueue::show(const console::OperatorConsole& console) {
  std::vector<std::string> panel = console::panel(console.view()), waiting = console.waiting();
  const std::lock_guard lock(mutex_);
  if (panel == panel_ && waiting == waiting_) return;
  panel_ = std::move(panel);
  waiting_ = std::move(waiting);
  ++newest_.version;
  changed_.notify_all();
}

void CommandQueue::operate(console::OperatorConsole& console) {
  while (!ending_ && !console.closed()) {
    answer_orders(&console, "");
    console.step(turn_s);
    show(console);
  }
}

void CommandQueue::run() {
  std::string problem;
  while (!ending_) {
    std::string before = std::exchange(problem, "the flight has closed the connection");
    try {
      console::OperatorConsole console(settings_, [this](const std::string& line) { say(line); });
      operate(console);
      before.clear();
    } catch (const std::exception& error) {
      problem = std::string("the flight cannot be reached: ") + error.what();
    }
    if (ending_) break;
    if (problem != before) say(problem + "; it is tried again every 5 s");
    const auto end = std::chrono::steady_clock::now() + patience;
    while (!ending_ && std::chrono::steady_clock::now() < end) {
      answer_orders(nullptr, problem);
      std::this_thread::sleep_for(std::chrono::duration<double>(turn_s));
    }
  }
  answer_orders(nullptr, "the server ends");
}

std::string CommandQueue::reports(const std::optional<Place>& place, std::chrono::milliseconds longest) const {
  std::unique_lock lock(mutex_);
  const bool full = !place || place->process != newest_.process || place->version > newest_.version;
  const std::uint64_t version = full ? 0 : place->version;
  if (!full) changed_.wait_for(lock, longest, [&] { return ending_ || newest_.version != version; });
  nlohmann::json lines = nlohmann::json::array();
  for (const Line& line : lines_) {
    if (line.version > version) lines.push_back({line.utc_ms, line.text});
  }
  const nlohmann::json answer = {{"place", text_of(newest_)},
                                 {"full", full},
                                 {"lines", std::move(lines)},
                                 {"panel", panel_},
                                 {"waiting", waiting_}};
  // What came down may be no UTF-8.
  return answer.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
}

}  // namespace ilp::serve
