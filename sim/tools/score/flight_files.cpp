#include <sstream>
#include <system_error>

#include "cfg/mission.hpp"
#include "sim/ground/intake/flight_database.hpp"
#include "sim/host/text_format.hpp"
#include "sim/tools/score/score.hpp"

namespace ilp::score {
namespace {
namespace fs = std::filesystem;

bool is_there(const fs::path& path) {
  std::error_code error;
  return fs::exists(path, error);
}

report::ReferenceFiles open_truth(const ScoreOptions& options) {
  if (!options.reference.empty()) return {options.reference, fs::path()};
  const fs::path truth = truth_folder(options);
  if (!is_there(truth / "poses.txt")) {
    throw std::runtime_error("no truth to score against: " + (truth / "poses.txt").string() +
                             " is not there (--truth FOLDER or --reference poses.txt name another)");
  }
  return {truth / "poses.txt", truth / "depth"};
}

void read_info(const ScoreOptions& options, FlightFiles& files) {
  const fs::path path = options.flight / "flight-info.json";
  if (!is_there(path)) {
    files.remarks.push_back("there is no flight-info.json: the flight did not end by itself");
    return;
  }
  try {
    files.info = intake::read_flight_info(path);
  } catch (const std::exception& error) {
    files.remarks.push_back(std::string("flight information cannot be used: ") + error.what());
  }
}

std::vector<intake::RecordEntry> onboard_records(const ScoreOptions& options, FlightFiles& files) {
  const fs::path path = options.flight / "flight.db";
  if (is_there(path)) return intake::read_flight_database(path);
  files.remarks.push_back("there is no flight.db: only what came down is scored");
  return {};
}

void read_down(const ScoreOptions& options, FlightFiles& files) {
  if (!is_there(options.flight / "outbox")) {
    files.remarks.push_back("there is no outbox: nothing came down");
    return;
  }
  files.outbox = intake::read_outbox(options.flight / "outbox");
}

// After the products were decoded: that finds damage too.
void remark_damage(FlightFiles& files) {
  std::size_t damaged = 0;
  std::string first;
  for (const intake::ReceivedFile& file : files.outbox.files) {
    if (file.fault.empty()) continue;
    if (damaged++ == 0) first = file.name + ", " + file.fault;
  }
  if (damaged > 0) {
    files.remarks.push_back(host::counted(damaged, "file") + " of the outbox cannot be used; the first: " + first);
  }
}

void remark_open_strips(FlightFiles& files) {
  for (const auto& [id, strip] : files.flight.strips) {
    if (!strip.record || strip.record->end != StripEnd::open) continue;
    files.remarks.push_back("strip " + std::to_string(id) + " was still open: its last poses are not final");
  }
}

}  // namespace

fs::path truth_folder(const ScoreOptions& options) {
  return options.truth.empty() ? options.flight / "flight" / "truth" : options.truth;
}

FlightFiles open_flight(const ScoreOptions& options) {
  if (!is_there(options.flight / "flight.db") && !is_there(options.flight / "outbox")) {
    throw std::runtime_error(options.flight.string() +
                             " holds no flight: expected flight.db and outbox/, as ilp-sil --out leaves them");
  }
  FlightFiles files;
  files.reference = open_truth(options);
  read_info(options, files);
  std::vector<intake::RecordEntry> onboard = onboard_records(options, files);
  read_down(options, files);
  // What came down is read last, so that it stands over what the database says.
  onboard.insert(onboard.end(), std::make_move_iterator(files.outbox.records.begin()),
                 std::make_move_iterator(files.outbox.records.end()));
  files.outbox.records = std::move(onboard);
  files.flight = intake::build_flight(files.outbox);
  remark_damage(files);
  remark_open_strips(files);
  files.complete = files.remarks.empty();
  files.remarks.insert(files.remarks.end(), files.flight.remarks.begin(), files.flight.remarks.end());
  files.target_overlap =
      (files.info ? files.info->target_overlap : std::nullopt).value_or(MissionParameters{}.target_overlap);
  return files;
}

}  // namespace ilp::score
