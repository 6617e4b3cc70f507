#include "sim/ground/serve/live_flight.hpp"

#include <chrono>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <ostream>
#include <set>
#include <string>

#include "sim/ground/received_flight.hpp"
#include "sim/ground/result_files.hpp"
#include "sim/ground/run_record.hpp"
#include "sim/ground/serve/live_items.hpp"
#include "sim/host/text_format.hpp"

namespace ilp::serve {
namespace {

constexpr std::chrono::seconds after_a_failure{60};

nlohmann::ordered_json run_item(const char* state, const std::string& problem, std::size_t updates) {
  const auto now = std::chrono::system_clock::now().time_since_epoch();
  return {{"state", state},
          {"problem", problem},
          {"updates", updates},
          {"utc_ms", std::chrono::duration_cast<std::chrono::milliseconds>(now).count()}};
}

// The catalogue is a database at work: a copy of it would not be whole.
std::set<std::string> served_files(const report::Report& report) {
  std::set<std::string> files;
  for (const std::string& file : ground::result_files(report)) {
    if (!file.starts_with("catalogue.")) files.insert(file);
  }
  return files;
}

}  // namespace

void LiveFlight::run(std::ostream& messages) {
  const auto begin = std::chrono::steady_clock::now();
  report::Report report;
  ground::naming_catalogue(options_, [&] { report = ground::run_ground(options_, messages); });
  options_.afresh = false;
  const std::set<std::string> files = served_files(report);
  Pictures pictures;
  const Items items = live_items(report, files, pictures);
  // The pictures first: the items name them.
  static_files_.put(std::move(pictures), files);
  const Update update = state_.replace(items);
  const std::chrono::duration<double> took = std::chrono::steady_clock::now() - begin;
  messages << "update " << ++updates_ << ": " << host::counted(update.items, "item") << ", " << update.json.size()
           << " bytes to each page, after " << host::fixed(took.count(), 2) << " s" << std::endl;
}

void LiveFlight::look(std::ostream& messages) {
  std::error_code unreadable;
  if (updates_ == 0 && std::filesystem::is_empty(options_.outbox, unreadable) && !unreadable) {
    if (greeted_) return;
    greeted_ = true;
    messages << "waiting for the first file in " << options_.outbox.string() << std::endl;
    state_.put("run", run_item("waiting", "", updates_));
    return;
  }
  std::string problem;
  try {
    const std::uint64_t inputs = ground::digest_of_inputs(options_);
    if (known_ == inputs && Clock::now() < again_) return;
    known_ = inputs;
    again_ = Clock::time_point::max();
    state_.put("run", run_item("merging", "", updates_));
    run(messages);
  } catch (const std::exception& error) {
    problem = error.what();
    again_ = Clock::now() + after_a_failure;
    messages << "ilp-ground serve: " << problem << std::endl;
  }
  state_.put("run", run_item("waiting", problem, updates_));
}

}  // namespace ilp::serve
