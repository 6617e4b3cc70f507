#include "sim/score/score_run.hpp"

#include <ostream>

#include "sim/ground/host_files.hpp"
#include "sim/score/score_json.hpp"

namespace ilp::score {

void run_score(const ScoreOptions& options, const std::filesystem::path& out, std::ostream& table) {
  const FlightFiles files = open_flight(options);
  const Score score = score_poses_of(files);
  const std::map<std::string, double> summary = summary_of(score);
  nlohmann::ordered_json json = score_json(score, files);
  json["summary"] = summary_json(summary);
  const std::filesystem::path path = out.empty() ? options.flight / "score.json" : out;
  // Names from damaged files need not be UTF-8.
  ground::write_file(path, json.dump(1, ' ', false, nlohmann::ordered_json::error_handler_t::replace) + "\n");
  write_table(score, summary, table);
  table << "score: " << path.string() << "\n";
}

}  // namespace ilp::score
