// ilp-score: scores one flight against the truth.

#include <CLI/CLI.hpp>
#include <iostream>

#include "sim/host/command_line.hpp"
#include "sim/host/version_line.hpp"
#include "sim/tools/score/score.hpp"

int main(int argc, char** argv) {
  try {
    using namespace ilp::score;
    ilp::host::CommandLine app(
        "ilp-score",
        "Scores what a flight found against the truth; a flight that was cut short is scored as far as it went",
        "ilp-score flight --reference poses.txt");
    ScoreOptions options;
    std::string out;
    app.add_option("flight", options.flight, "folder that ilp-sil --out left")->required();
    const auto truth = app.add_option("--truth", options.truth,
                                      "folder with poses.txt and depth/NAME.pfm (default: flight/truth in the flight)");
    app.add_option("--received", options.received,
                   "folder of the files that came down over a link (default: outbox in the flight)");
    app.add_option("--reference", options.reference,
                   "reference poses of a recorded strip, which take the place of the truth")
        ->excludes(truth);
    app.add_option("--out", out, "the file to write (default: score.json in the flight)");
    app.set_version_flag("--version", ilp::host::version_line("ilp-score"));
    if (const auto end = ilp::host::read_command_line(app, argc, argv)) return *end;
    run_score(options, out, std::cout);
    return 0;
  } catch (const std::exception& error) {
    std::cerr << "ilp-score: " << error.what() << "\n";
    return 1;
  }
}
