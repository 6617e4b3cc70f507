// Common parts of the subcommands of ilp-lab: command line, timing, verdicts, exit status.
#pragma once

#include <CLI/CLI.hpp>
#include <functional>
#include <iosfwd>
#include <memory>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <string>
#include <vector>

#include "fsw/base/status.hpp"
#include "sim/host/command_line.hpp"

namespace ilp::lab {

/// JSON whose members keep their order. Numbers that are not finite become null.
using Json = nlohmann::ordered_json;

/// Thrown for a mistake in the command line (exit status 2). Any other exception means bad input (exit status 1).
using UsageError = host::WrongUsage;

/// Runs a subcommand. `repeat` is the value of --repeat. The result is printed as JSON, a string as plain text.
using Command = std::function<Json(int repeat)>;

class Lab {
 public:
  explicit Lab(CLI::App& app) : app_(app) {}
  /// Adds a subcommand with the option --repeat; the caller adds the others. `example` is the example's command line
  /// after the name.
  CLI::App& add(const std::string& name, const std::string& description, const std::string& example, Command command);
  /// Runs the subcommand that the parsed command line names.
  [[nodiscard]] Json run() const;

 private:
  struct Entry {
    CLI::App* app = nullptr;
    Command command;
    int repeat = 1;
  };
  CLI::App& app_;
  std::vector<std::unique_ptr<Entry>> entries_;
};

/// Runs the program: writes a JSON object or a text to `out`, or a message to `err`. Returns the exit status.
int run_lab(int argc, char** argv, std::ostream& out, std::ostream& err);

/// Accepts numbers in [low, high]. Unlike CLI::Range it refuses NaN.
[[nodiscard]] CLI::Validator finite_in(double low, double high);

/// Name of a status that is a result: "ok", or a property of the data such as too few matches or no model. Throws
/// std::runtime_error("WHAT: ...") for a status that means wrong input.
[[nodiscard]] std::string verdict_of(const Status& status, const std::string& what);

/// Median of unsorted values (mean of two middle values); 0 if there are none.
[[nodiscard]] double median(std::vector<double> values);

/// Median duration of `repeat` runs of `kernel`, in ms. For repeat > 1 an untimed run comes first. `prepare` is called
/// before each run and is not timed.
double time_kernel(int repeat, const std::function<void()>& prepare, const std::function<void()>& kernel);

void add_match_commands(Lab& lab);
void add_two_view_commands(Lab& lab);
void add_bundle_command(Lab& lab);
void add_calibrate_target_command(Lab& lab);
void add_rectify_command(Lab& lab);
void add_stereo_command(Lab& lab);
void add_encode_command(Lab& lab);
void add_richness_command(Lab& lab);
void add_pose_strip_command(Lab& lab);
void add_select_command(Lab& lab);
void add_world_map_command(Lab& lab);

}  // namespace ilp::lab
