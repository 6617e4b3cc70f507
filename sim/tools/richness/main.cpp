// ilp-richness: tests on simulated worlds with planted features whether the Image Richness Index finds interesting
// images.

#include <CLI/CLI.hpp>
#include <fstream>
#include <iostream>

#include "fsw/products/richness_scorer.hpp"
#include "sim/host/command_line.hpp"
#include "sim/host/mission_input.hpp"
#include "sim/host/version_line.hpp"
#include "sim/tools/richness/evaluation.hpp"
#include "sim/tools/richness/pictures.hpp"

namespace {

using namespace ilp;
using namespace ilp::richness;

struct Options {
  std::string set = "held-out";
  std::string mission, csv, roc, out;
  std::uint64_t first_seed = 1;
  std::uint64_t seeds = 8;
  std::size_t threads = 0;
  int count = 64;
  int keyframes = 8;
  bool cues = false;

  [[nodiscard]] WorldRange range() const {
    return {set == "tuning" ? WorldSet::tuning : WorldSet::held_out, first_seed, seeds};
  }
  [[nodiscard]] RichnessParams params() const { return richness_params(host::read_mission(mission)); }
};

void write(const std::string& path, const std::string& text) {
  if (!(std::ofstream(path, std::ios::binary) << text).flush()) throw std::runtime_error("cannot write " + path);
}

void run_evaluate(const Options& options) {
  const std::vector<EvaluatedImage> images = evaluate(options.range(), Viewing{}, options.params(), options.threads);
  std::cout << auc_table(images);
  if (options.cues) std::cout << "\nevery cue alone\n" << cue_table(images);
  if (!options.csv.empty()) write(options.csv, csv(images));
  if (!options.roc.empty()) write(options.roc, roc_svg(images));
}

void run_stability(const Options& options) {
  std::vector<ViewingChange> changes = viewing_changes();
  for (ViewingChange& change : changes) change.viewing.keyframes = options.keyframes;
  std::cout << stability_table(stability(options.range(), changes, options.params(), options.threads));
}

void run_tune(const Options& options) {
  std::vector<EvaluatedImage> images = evaluate(options.range(), Viewing{}, options.params(), options.threads);
  const RichnessParams fitted = fit_richness(images);
  std::cout << "; fitted to " << options.set << " worlds, seeds " << options.first_seed << " to "
            << options.first_seed + options.seeds - 1 << "\n[richness]\n";
  for (const NamedCue& cue : named_cues()) {
    const CueScale& scale = fitted.*cue.scale;
    std::cout << cue.name << "_half = " << scale.half << "\n" << cue.name << "_weight = " << scale.weight << "\n";
  }
  score_again(fitted, images);
  std::cerr << auc_table(images);
}

}  // namespace

int main(int argc, char** argv) {
  try {
    host::CommandLine app("ilp-richness",
                          "Rates images of simulated worlds with planted features by their richness, and compares the "
                          "rates with the truth",
                          "ilp-richness evaluate --seeds 2");
    app.require_subcommand(1);
    Options options;
    const auto add = [&](const char* name, const char* about, const char* example, void (*run)(const Options&)) {
      CLI::App* command = &host::add_subcommand(app, name, about, "ilp-richness " + std::string(example));
      command->add_option("--set", options.set, "which worlds: held-out or tuning")
          ->check(CLI::IsMember({"held-out", "tuning"}));
      command->add_option("--first-seed", options.first_seed, "first seed of the worlds");
      command->add_option("--seeds", options.seeds, "number of seeds; each makes 25 worlds of 8 keyframes")
          ->check(CLI::Range(1, 10000));
      command->add_option("--threads", options.threads, "number of threads; 0: one per core");
      command->add_option("--mission", options.mission,
                          "mission file with the parameters of the flight software, such as [richness]");
      command->callback([&options, run] { run(options); });
      return command;
    };
    CLI::App* evaluate_command = add("evaluate", "area under the ROC curve by ground and by feature",
                                     "evaluate --seeds 2 --csv cues.csv", run_evaluate);
    evaluate_command->add_flag("--cues", options.cues, "evaluate every cue alone, too");
    evaluate_command->add_option("--csv", options.csv, "CSV file with the cues of each image");
    evaluate_command->add_option("--roc", options.roc, "SVG file with the ROC curves");
    add("stability", "index of the same ground under other exposures, heights, noise and haze", "stability --seeds 2",
        run_stability)
        ->add_option("--keyframes", options.keyframes, "number of keyframes of each world")
        ->check(CLI::Range(1, 1000));
    add("tune", "fits halves and weights for a mission file; needs --set tuning", "tune --set tuning", run_tune);
    CLI::App* sheet =
        add("sheet", "newly seen parts of images in the order of their richness index", "sheet --out sheet.png",
            [](const Options& o) { write_contact_sheet(o.out, o.range(), o.params(), o.count, o.threads); });
    sheet->add_option("--out", options.out, "PNG file to write")->required();
    sheet->add_option("--count", options.count, "number of parts shown")->check(CLI::Range(1, 400));
    app.set_version_flag("--version", ilp::host::version_line("ilp-richness"));
    if (const auto end = ilp::host::read_command_line(app, argc, argv)) return *end;
    return 0;
  } catch (const std::exception& error) {
    std::cerr << "ilp-richness: " << error.what() << "\n";
    return 1;
  }
}
