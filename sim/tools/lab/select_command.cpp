// select: the images of a strip or video that the flight's overlap checker would keep, and why.

#include <algorithm>
#include <array>
#include <cstdio>
#include <memory>

#include "fsw/base/math.hpp"
#include "sim/host/mission_input.hpp"
#include "sim/host/status_error.hpp"
#include "sim/tools/lab/frame_selection.hpp"
#include "sim/tools/lab/lab.hpp"

namespace ilp::lab {
namespace {

struct SelectOptions {
  std::string folder, video, mission;
  double target = 0, minimum = 0;  ///< 0: the mission's
  bool full_turn = false, list = false, json = false;
};

MissionParameters mission_for(const SelectOptions& options) {
  MissionParameters mission = host::read_mission(options.mission);
  if (options.target > 0) mission.target_overlap = options.target;
  if (options.minimum > 0) mission.min_overlap = options.minimum;
  if (options.full_turn) mission.max_rotation_rad = pi;
  if (mission.target_overlap <= mission.min_overlap) {
    char text[120];
    std::snprintf(text, sizeof(text), "target overlap %g: expected more than the minimum overlap, %g",
                  mission.target_overlap, mission.min_overlap);
    throw std::runtime_error(text);
  }
  host::require(validate(mission), "mission parameters");
  return mission;
}

std::unique_ptr<ImageSequence> open_images(const SelectOptions& options) {
  if (options.folder.empty() == options.video.empty()) throw UsageError("expected either DIR or --y4m");
  if (!options.video.empty()) return std::make_unique<VideoSequence>(options.video);
  return std::make_unique<FileSequence>(host::list_strip(options.folder));
}

using Counts = std::array<std::size_t, static_cast<std::size_t>(Decision::count)>;

Counts count_decisions(const std::vector<FrameChoice>& choices) {
  Counts counts{};
  for (const FrameChoice& choice : choices) ++counts[static_cast<std::size_t>(choice.decision)];
  return counts;
}

std::size_t count_of(const Counts& counts, Decision decision) {
  return counts[static_cast<std::size_t>(decision)];
}

double degrees(double radians) {
  return radians * 180 / pi;
}

std::string line_of(const FrameChoice& choice, std::size_t name_width) {
  char numbers[64] = "    -         -      -";
  if (choice.measured) {
    std::snprintf(numbers, sizeof(numbers), "%.3f  %8.2f  %.3f", choice.overlap, degrees(choice.rotation_rad),
                  choice.scale);
  }
  std::string name = short_name(choice);
  name.resize(std::max(name.size(), name_width), ' ');
  char head[48];
  std::snprintf(head, sizeof(head), "  %-11s  ", decision_name(choice.decision));
  char verdict[32];
  std::snprintf(verdict, sizeof(verdict), "  %-15s  ", choice.verdict.empty() ? "-" : choice.verdict.c_str());
  return name + head + numbers + verdict + choice.reason + "\n";
}

std::string summary_of(const Counts& counts, std::size_t images) {
  const std::size_t strips = count_of(counts, Decision::new_strip);
  std::string text = "kept " + std::to_string(count_of(counts, Decision::kept) + strips) + " of " +
                     std::to_string(images) + " images in " + std::to_string(strips) +
                     (strips == 1 ? " strip" : " strips");
  for (const Decision decision : {Decision::skipped, Decision::rejected, Decision::passed_over}) {
    if (count_of(counts, decision) == 0) continue;
    text += ", " + std::to_string(count_of(counts, decision)) + " " + decision_name(decision);
  }
  return text + "\n";
}

std::string table_of(const std::vector<FrameChoice>& choices) {
  std::size_t name_width = 5;
  for (const FrameChoice& choice : choices) name_width = std::max(name_width, short_name(choice).size());
  std::string text =
      "image" + std::string(name_width - 5, ' ') + "  decision     overlap  rot_deg  scale  verdict          reason\n";
  for (const FrameChoice& choice : choices) text += line_of(choice, name_width);
  return text + summary_of(count_decisions(choices), choices.size());
}

std::string list_of(const std::vector<FrameChoice>& choices) {
  std::string text;
  for (const FrameChoice& choice : choices) {
    if (is_kept(choice.decision)) text += choice.name + "\n";
  }
  return text;
}

Json json_of(const std::vector<FrameChoice>& choices, const MissionParameters& mission) {
  const Counts counts = count_decisions(choices);
  Json images = Json::array();
  for (const FrameChoice& choice : choices) {
    const bool compared = choice.keyframe != FrameChoice::none;
    images.push_back({{"name", choice.name},
                      {"decision", decision_name(choice.decision)},
                      {"strip", choice.strip > 0 ? Json(choice.strip) : Json()},
                      {"keyframe", compared ? Json(choices[choice.keyframe].name) : Json()},
                      {"overlap", choice.measured ? Json(choice.overlap) : Json()},
                      {"rotation_deg", choice.measured ? Json(degrees(choice.rotation_rad)) : Json()},
                      {"scale", choice.measured ? Json(choice.scale) : Json()},
                      {"verdict", choice.verdict.empty() ? Json() : Json(choice.verdict)},
                      {"reason", choice.reason}});
  }
  const std::size_t strips = count_of(counts, Decision::new_strip);
  const std::size_t kept = count_of(counts, Decision::kept) + strips;
  return {{"verdict", kept > 0 ? "ok" : "nothing_kept"},
          {"frames", choices.size()},
          {"kept", kept},
          {"skipped", count_of(counts, Decision::skipped)},
          {"rejected", count_of(counts, Decision::rejected)},
          {"passed_over", count_of(counts, Decision::passed_over)},
          {"strips", strips},
          {"target_overlap", mission.target_overlap},
          {"min_overlap", mission.min_overlap},
          {"images", images}};
}

Json run_select(const SelectOptions& options, int repeat) {
  if (repeat > 1) throw UsageError("select times nothing: expected no --repeat");
  if (options.list && options.json) throw UsageError("expected at most one of --list and --json");
  const MissionParameters mission = mission_for(options);
  const auto images = open_images(options);
  const std::vector<FrameChoice> choices = select_frames(*images, mission);
  if (options.json) return json_of(choices, mission);
  return options.list ? list_of(choices) : table_of(choices);
}

}  // namespace

void add_select_command(Lab& lab) {
  const auto options = std::make_shared<SelectOptions>();
  CLI::App& app = lab.add("select", "a table of the images of a strip or video that the flight would keep, and why",
                          [options](int repeat) { return run_select(*options, repeat); });
  app.add_option("DIR", options->folder,
                 "folder of PNG or PGM images in the order of their names, or of its times.txt");
  app.add_option("--y4m", options->video, "YUV4MPEG2 file that takes the place of the folder, - for standard input");
  app.add_option("--target,--target-overlap", options->target,
                 "an image at or below this overlap with the last one kept is kept (default 0.82)")
      ->check(finite_in(0.5, 0.98));
  app.add_option("--minimum", options->minimum, "below this overlap the strip ends (default 0.55)")
      ->check(finite_in(0.2, 0.95));
  app.add_flag("--full-turn", options->full_turn, "search every rotation between images (default 0.35 rad)");
  app.add_option("--mission", options->mission, "mission parameters, an .ini file; its capture times are ignored");
  app.add_flag("--list", options->list, "print only the names of the kept images, one a line");
  app.add_flag("--json", options->json, "print one JSON object");
}

}  // namespace ilp::lab
