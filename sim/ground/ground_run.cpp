#include "sim/ground/ground_run.hpp"

#include <map>
#include <memory>
#include <ostream>
#include <stdexcept>

#include "cfg/mission.hpp"
#include "sim/ground/export/flight_tables.hpp"
#include "sim/ground/export/shared_catalogue.hpp"
#include "sim/ground/export/strip_exports.hpp"
#include "sim/ground/intake/catalogue.hpp"
#include "sim/ground/intake/flight_info.hpp"
#include "sim/ground/intake/flight_model.hpp"
#include "sim/ground/previous_results.hpp"
#include "sim/ground/received_flight.hpp"
#include "sim/ground/report/accuracy.hpp"
#include "sim/ground/report/report.hpp"
#include "sim/ground/tasks/work_result.hpp"
#include "sim/ground/viewer/viewer_page.hpp"
#include "sim/host/files.hpp"
#include "sim/host/progress.hpp"
#include "sim/host/text_format.hpp"

namespace ilp::ground {
namespace {
namespace fs = std::filesystem;

std::unique_ptr<report::Reference> open_reference(const GroundOptions& options) {
  if (!options.truth.empty())
    return std::make_unique<report::ReferenceFiles>(options.truth / "poses.txt", options.truth / "depth");
  if (!options.reference.empty()) return std::make_unique<report::ReferenceFiles>(options.reference, fs::path());
  return nullptr;
}

std::string title_of(const GroundOptions& options) {
  if (!options.title.empty()) return options.title;
  const fs::path folder = fs::absolute(options.outbox).lexically_normal();
  fs::path name = folder.filename().empty() ? folder.parent_path().filename() : folder.filename();
  // The outbox of a flight has a fixed name: its flight's folder says more.
  if (name == "outbox" && folder.parent_path().has_filename()) name = folder.parent_path().filename();
  return name.string();
}

void measure_strip(const report::Report& report, report::StripResult& result) {
  const std::vector<intake::TrackPoint> track = intake::track_of(report.flight, result.strip);
  result.posed = track.size();
  for (std::size_t i = 1; i < track.size(); ++i) result.track_length += (track[i].centre - track[i - 1].centre).norm();
  std::vector<double> heights;
  double masked = 0, pixels = 0;
  for (const intake::TrackPoint& point : track) {
    const intake::Keyframe& keyframe = report.flight.keyframes.at(point.keyframe_id);
    const map::KeyframeLook& look = report.looks.at(point.keyframe_id);
    pixels += static_cast<double>(keyframe.camera.width) * keyframe.camera.height;
    masked += static_cast<double>(look.depth_pixels);
    if (look.median_depth > 0) heights.push_back(look.median_depth);
  }
  result.flying_height = heights.empty() ? 0 : host::median(std::move(heights));
  result.mask_share = pixels > 0 ? masked / pixels : 0;
}

void merge_and_export(const GroundOptions& options, const report::Report& report, const exports::Anchors* anchors,
                      intake::Catalogue& catalogue, report::StripResult& result, std::ostream& messages) {
  const intake::Strip& strip = result.strip;
  result.colmap = exports::write_colmap_model(report.flight, strip, options.out / ("colmap" + result.suffix));
  const auto map = map::merge_strip(report.flight, strip, views_of(report, strip), catalogue, {},
                                    host::Progress(messages, "merging strip " + std::to_string(strip.id)));
  if (!map) {
    (void)exports::export_track(report.flight, anchors, options.out, result);
    return;
  }
  result.geometry = map->mosaic.geometry;
  result.map = map->statistics;
  result.seams = map::measure_seams(map->mosaic);
  result.grid = map::overview(map->mosaic, {});
  result.plane = map::mean_plane(*result.grid);
  exports::export_grid(*result.grid, result.suffix, options.out);
  exports::export_strip(report.flight, map->mosaic, anchors, options.max_vertices, options.out, result);
}

void share(const GroundOptions& options, const report::Report& report, const exports::Anchors* anchors) {
  std::vector<const exports::ExportedStrip*> strips;
  for (const report::StripResult& strip : report.strips) strips.push_back(&strip);
  exports::write_shared_catalogue(options.catalogue, options.mission.empty() ? report.title : options.mission,
                                  report.flight, strips, anchors);
}

}  // namespace

/// A telecommand may have changed it after the flight information was written.
double target_overlap_of(const GroundOptions& options, const std::optional<intake::FlightInfo>& info) {
  if (options.target_overlap > 0) return options.target_overlap;
  if (!options.flight_db.empty()) {
    const std::optional<double> set = intake::read_setting(options.flight_db, "overlap.target_overlap");
    if (set) return *set;
  }
  return info && info->target_overlap ? *info->target_overlap : unknown;
}

report::Report run_ground(const GroundOptions& options, std::ostream& messages) {
  // Inputs that the user named are checked before any work: a typing error shows at once.
  if (fs::is_directory(options.outbox / "outbox") && fs::exists(options.outbox / "flight.db")) {
    throw std::runtime_error(options.outbox.string() + " is the folder of a flight: name its downlink, " +
                             (options.outbox / "outbox").string());
  }
  const std::unique_ptr<report::Reference> reference = open_reference(options);
  report::Report report;
  if (!options.flight_info.empty()) report.info = intake::read_flight_info(options.flight_info);
  if (!options.score.empty()) report.score = report::read_score(options.score);
  report.title = title_of(options);
  std::optional<exports::Anchors> anchors;
  if (!options.anchor.empty())
    anchors = exports::read_anchors(options.anchor, report.info ? exports::flown_body(report.info->source) : nullptr);
  if (!options.catalogue.empty()) exports::prepare_shared_catalogue(options.catalogue);
  const std::unique_ptr<intake::Catalogue> opened = open_and_take_in(options, report, messages);
  intake::Catalogue& catalogue = *opened;
  decode_held(options, catalogue, report, messages);
  remove_previous_results(options.out, report.flight);
  if (!options.acknowledge.empty()) intake::write_acknowledgements(report.outbox, options.acknowledge);

  report.target_overlap = target_overlap_of(options, report.info);
  report.has_reference = reference != nullptr;
  report.missing = intake::missing_of(report.flight);
  if (!report.missing.empty())
    messages << host::counted(report.missing.size(), "thing") << " missing: see the report\n";
  if (!options.images.empty()) report::measure_image_quality(options.images, report);
  for (const intake::Strip* strip : strips_with_poses_first(report.flight)) {
    report::StripResult& result = report.strips.emplace_back();
    result.strip = *strip;
    result.suffix = report.strips.size() == 1 ? "" : "-strip-" + std::to_string(strip->id);
    measure_strip(report, result);
    merge_and_export(options, report, anchors ? &*anchors : nullptr, catalogue, result, messages);
    if (reference) result.accuracy = report::measure_accuracy(report.flight, *strip, *reference);
  }
  report.has_viewer = viewer::viewer_available();
  report.tables = exports::write_flight_tables(report.flight, options.out);
  host::write_file(options.out / "report.json", report::report_json(report));
  host::write_file(options.out / "report.html", report::report_html(report));
  if (report.has_viewer) host::write_file(options.out / "viewer.html", viewer::viewer_html(report));
  if (!options.catalogue.empty()) share(options, report, anchors ? &*anchors : nullptr);
  fs::remove_all(tasks::work_folder(options.out));
  return report;
}

}  // namespace ilp::ground
