// ilp-ground: makes elevation maps, a surface model, poses and a report from downlinked files.

#include <CLI/CLI.hpp>
#include <chrono>
#include <filesystem>
#include <iostream>
#include <optional>
#include <string>
#include <system_error>
#include <thread>
#include <vector>

#include "sim/ground/compare_command.hpp"
#include "sim/ground/console/console_main.hpp"
#include "sim/ground/flight_options.hpp"
#include "sim/ground/ground_run.hpp"
#include "sim/ground/intake/outbox_reader.hpp"
#include "sim/ground/map/damaged_catalogue.hpp"
#include "sim/ground/map_check_command.hpp"
#include "sim/ground/map_tiles_command.hpp"
#include "sim/ground/merge_command.hpp"
#include "sim/ground/received_flight.hpp"
#include "sim/ground/serve/serve_main.hpp"
#include "sim/ground/tasks/worker.hpp"
#include "sim/ground/work_steps.hpp"
#include "sim/host/command_line.hpp"
#include "sim/host/text_format.hpp"
#include "sim/host/version_line.hpp"

namespace {
using namespace ilp;
using ground::GroundOptions;

int run_once(const GroundOptions& options) {
  try {
    std::optional<std::vector<std::string>> lines = ground::summary_if_unchanged(options, std::cerr);
    if (!lines) {
      ground::naming_catalogue(options,
                               [&] { lines = ground::summary_of(options, ground::run_ground(options, std::cerr)); });
    }
    for (const std::string& line : *lines) std::cout << line << "\n";
    return 0;
  } catch (const std::exception& error) {
    std::cerr << "ilp-ground: " << error.what() << "\n";
    return 1;
  }
}

int plan(const GroundOptions& options, const std::string& kind, std::size_t count) {
  try {
    ground::naming_catalogue(
        options, [&] { std::cout << ground::plan_work(options, *tasks::kind_of(kind), count, std::cerr) << "\n"; });
    return 0;
  } catch (const std::exception& error) {
    std::cerr << "ilp-ground: " << error.what() << "\n";
    return 1;
  }
}

/// ilp-ground work PACKAGE --out DIR
int work_main(int argc, char** argv) {
  host::CommandLine app("ilp-ground work",
                        "Does the work of a package that ilp-ground --plan has written (ilp-ground merge does both)",
                        "ilp-ground work ground/work/looks-1.work --out ground");
  std::string package, out;
  tasks::WorkParams params;
  app.add_option("package", package, "file below DIR/work")->required();
  app.add_option("--out", out, "folder for the results of the run, DIR")->required();
  app.add_option("--threads", params.threads, "threads; 0: one per core")->check(CLI::Range(0, 1024));
  if (const auto end = ilp::host::read_command_line(app, argc, argv)) return *end;
  try {
    const tasks::WorkDone done = tasks::do_work(package, out, params);
    std::cout << host::counted(done.items, "piece") << " of work done, " << done.before
              << " of them by an earlier run\n";
    return 0;
  } catch (const map::DamagedCatalogue& part) {
    std::cerr << "ilp-ground: " << package << " is damaged: " << part.what() << "; plan the work again\n";
    return 1;
  } catch (const std::exception& error) {
    std::cerr << "ilp-ground: " << error.what() << "\n";
    return 1;
  }
}

/// Names, sizes and times of the files: what changes when something comes.
std::string state_of(const std::filesystem::path& folder) {
  std::string state;
  for (const std::filesystem::path& path : intake::files_of(folder)) {
    std::error_code error;
    state += path.filename().string() + " " + std::to_string(std::filesystem::file_size(path, error)) + " " +
             std::to_string(std::filesystem::last_write_time(path, error).time_since_epoch().count()) + "\n";
  }
  return state;
}

int follow(GroundOptions options, int seconds) {
  std::string known;
  while (true) {
    try {
      const std::string state = state_of(options.outbox);
      if (state != known) {
        (void)run_once(options);
        options.afresh = false;
      }
      known = state;
    } catch (const std::exception& error) {
      std::cerr << "ilp-ground: " << error.what() << "\n";
    }
    std::this_thread::sleep_for(std::chrono::seconds(seconds));
  }
}

struct Subcommand {
  const char* name;
  const char* what;
  int (*run)(int argc, char** argv);  ///< with the program's name before the subcommand's
};

constexpr Subcommand subcommands[] = {
    {"merge", "does the same in tasks on several processors or machines", ground::merge_main},
    {"work", "does the work of one task", [](int argc, char** argv) { return work_main(argc - 1, argv + 1); }},
    {"compare", "measures the height differences of a map to another terrain model", ground::compare_main},
    {"map-tiles", "makes the map that a flight carries", ground::map_tiles_main},
    {"map-check", "tries a map on a flight that came down", ground::map_check_main},
    {"serve", "shows a live flight in a browser",
     [](int argc, char** argv) { return serve::serve_main(argc - 1, argv + 1); }},
    {"console", "operates a flight over its link",
     [](int argc, char** argv) { return console::console_main(argc - 1, argv + 1); }}};

std::string list_of_subcommands() {
  constexpr std::size_t column = 12;
  std::string text = "Subcommands, each with a --help of its own:\n";
  for (const Subcommand& subcommand : subcommands) {
    std::string name = subcommand.name;
    name.resize(column, ' ');
    text += "  " + name + subcommand.what + "\n";
  }
  return text + "\n";
}

/// Where the first word is no folder: the subcommand that is spelled much like it.
std::string nearest_subcommand(const std::string& word) {
  std::error_code error;
  if (word.empty() || word.starts_with("-") || std::filesystem::exists(word, error)) return {};
  std::vector<std::string> names;
  for (const Subcommand& subcommand : subcommands) names.emplace_back(subcommand.name);
  return host::did_you_mean(word, names);
}

int run(int argc, char** argv) {
  const std::string first = argc > 1 ? argv[1] : "";
  for (const Subcommand& subcommand : subcommands) {
    if (first == subcommand.name) return subcommand.run(argc, argv);
  }
  if (const std::string near = nearest_subcommand(first); !near.empty()) {
    std::cerr << "ilp-ground: " << first << " is neither a folder nor a subcommand" << near
              << "\nRun with --help for more information.\n";
    return host::wrong_usage;
  }
  host::CommandLine app("ilp-ground",
                        "Decodes the files of a downlink, merges them into one model per strip, and writes a report",
                        "ilp-ground flight/outbox --out ground --flight-info flight/flight-info.json");
  app.footer(list_of_subcommands() + app.get_footer());
  GroundOptions options;
  app.add_option("outbox", options.outbox, "folder with the files that came down (.ilp, .jp2)")->required();
  app.add_option("--out", options.out, "folder for the results")->required();
  const auto truth =
      app.add_option("--truth", options.truth, "folder of the simulator's truth: poses.txt and depth/NAME.pfm");
  app.add_option("--reference", options.reference, "reference poses of a recorded strip, in the camera text format")
      ->excludes(truth);
  app.add_option("--flight-db", options.flight_db,
                 "onboard database, which shows what was not sent down; it is only read");
  app.add_option("--flight-info", options.flight_info, "JSON file of ilp-sil with the cost of the run");
  app.add_option("--images", options.images, "folder of the original images, which show what compression has lost");
  app.add_option("--colour", options.colour,
                 "folder of the photographs in colour that flew in grey: a colour orthoimage of each strip");
  app.add_flag("--afresh", options.afresh,
               "forget everything that earlier runs read and computed in the folder for the results");
  app.add_flag("--check", options.check,
               "read all files of the results, to find damage that has left their sizes and times as they were");
  ground::add_flight_options(app, options);
  app.add_option("--control-points", options.control,
                 "CSV file of ground control points and their marks in images: they place, scale and level the map")
      ->excludes(app.get_option("--anchor"));
  app.add_option("--control-body", options.control_body, "body of control points in longitude and latitude")
      ->check(CLI::IsMember({"mars", "titan", "venus", "moon", "earth"}));
  app.add_option("--control-crs", options.control_crs,
                 "coordinate system of the control points' x and y, such as EPSG:32633");
  app.add_option("--geoid", options.geoid,
                 "heights of control points are above the geoid: its height above the ellipsoid in metres, or a raster "
                 "of it such as egm96_15.gtx");
  app.add_flag("--control-original", options.control_original,
               "control points are marked in the photographs as they came, also where smaller ones flew");
  app.add_option("--catalogue", options.catalogue,
                 "postgresql://USER@HOST/DATABASE: keep the catalogue there, where missions share it, with footprints");
  app.add_option("--mission", options.mission, "name of the mission in that catalogue (default: the title)");
  app.add_option("--target-overlap", options.target_overlap, "target overlap that the plot shows, 0 to 1")
      ->check(CLI::Range(0.0, 1.0))
      ->default_str("");
  const auto vertices = app.add_option("--max-vertices", options.max_vertices, "most vertices of one surface model")
                            ->check(CLI::Range(100, 100000000));
  std::string keep = "all";
  app.add_option("--keep", keep,
                 "all, or maps: leaves out what other files contain already (PFM, model.ply, the catalogue), and a "
                 "surface of 80 000 vertices")
      ->check(CLI::IsMember({"all", "maps"}));
  std::string holes = "laid";
  app.add_option("--holes", holes,
                 "ground that images show without a height: laid (default: the pages show it hatched, on interpolated "
                 "heights) or open; heights and their errors never have it, and laid.tif has its grey")
      ->check(CLI::IsMember({"laid", "open"}));
  int follow_s = 0;
  app.add_option("--follow", follow_s,
                 "seconds between two searches for new files; the program then runs until it is ended")
      ->check(CLI::Range(1, 86400))
      ->default_str("");
  std::string planned;
  app.add_option("--plan", planned,
                 "only take in what is new, and write packages of this kind of work for tasks (ilp-ground merge)")
      ->check(CLI::IsMember({"looks", "tiles", "finish"}));
  std::size_t task_count = 1;
  app.add_option("--tasks", task_count, "most packages that --plan writes")->check(CLI::Range(1, 1000));
  app.set_version_flag("--version", ilp::host::version_line("ilp-ground"));
  if (const auto end = ilp::host::read_command_line(app, argc, argv)) return *end;
  options.keep_copies = keep == "all";
  options.lay_holes = holes == "laid";
  if (!options.keep_copies && vertices->count() == 0) options.max_vertices = 80000;
  options.more_comes = follow_s > 0;
  ground::require_apart(options);
  if (!planned.empty()) return plan(options, planned, task_count);
  return follow_s > 0 ? follow(options, follow_s) : run_once(options);
}

}  // namespace

int main(int argc, char** argv) {
  try {
    return run(argc, argv);
  } catch (const host::WrongUsage& error) {
    std::cerr << "ilp-ground: " << error.what() << "\n";
    return host::wrong_usage;
  } catch (const std::exception& error) {
    std::cerr << "ilp-ground: " << error.what() << "\n";
    return 1;
  }
}
