#include "sim/ground/ground_run.hpp"

#include <algorithm>
#include <map>
#include <memory>
#include <ostream>
#include <set>
#include <stdexcept>

#include "cfg/mission.hpp"
#include "sim/ground/export/colour_ortho.hpp"
#include "sim/ground/export/flight_tables.hpp"
#include "sim/ground/export/shared_catalogue.hpp"
#include "sim/ground/export/strip_exports.hpp"
#include "sim/ground/fixes/fix_text.hpp"
#include "sim/ground/intake/catalogue.hpp"
#include "sim/ground/intake/flight_info.hpp"
#include "sim/ground/intake/flight_model.hpp"
#include "sim/ground/kept_map.hpp"
#include "sim/ground/received_flight.hpp"
#include "sim/ground/report/accuracy.hpp"
#include "sim/ground/report/accuracy_summary.hpp"
#include "sim/ground/report/camera_lines.hpp"
#include "sim/ground/report/report.hpp"
#include "sim/ground/result_files.hpp"
#include "sim/ground/run_record.hpp"
#include "sim/ground/tasks/work_result.hpp"
#include "sim/ground/viewer/viewer_page.hpp"
#include "sim/host/files.hpp"
#include "sim/host/progress.hpp"
#include "sim/host/text_format.hpp"
#include "sim/host/wrong_usage.hpp"

namespace ilp::ground {
namespace {
namespace fs = std::filesystem;

std::unique_ptr<report::Reference> open_reference(const GroundOptions& options) {
  if (!options.truth.empty())
    return std::make_unique<report::ReferenceFiles>(options.truth / "poses.txt", options.truth / "depth");
  if (!options.reference.empty()) return std::make_unique<report::ReferenceFiles>(options.reference, fs::path());
  return nullptr;
}

void measure_strip(const report::Report& report, report::StripResult& result) {
  const std::vector<intake::TrackPoint> track = intake::track_of(report.flight, result.strip);
  result.posed = track.size();
  for (std::size_t i = 1; i < track.size(); ++i) result.track_length += (track[i].centre - track[i - 1].centre).norm();
  std::vector<double> heights;
  double masked = 0, pixels = 0;
  for (const intake::TrackPoint& point : track) {
    const intake::Keyframe& keyframe = report.flight.keyframes.at(point.keyframe_id);
    const map::KeyframeQuickLook& quick_look = report.quick_looks.at(point.keyframe_id);
    pixels += static_cast<double>(keyframe.camera.width) * keyframe.camera.height;
    masked += static_cast<double>(quick_look.depth_pixels);
    if (quick_look.median_depth > 0) heights.push_back(quick_look.median_depth);
  }
  result.flying_height = heights.empty() ? 0 : host::median(std::move(heights));
  result.mask_share = pixels > 0 ? masked / pixels : 0;
}

/// The map of one strip and all files that follow from it. Where `before` and the catalogue know them, the files stay.
class MapExport {
 public:
  MapExport(const GroundOptions& options, const RunRecord& before, intake::Catalogue& catalogue)
      : options_(options), before_(before), catalogue_(catalogue) {}

  void operator()(const map::StripMap& map, const exports::Georeference& place, report::StripResult& result) {
    const std::uint64_t digest = map_export_digest(map.digest, place, result.suffix, options_.max_vertices);
    if (keep(digest, result)) {
      result.files.insert(result.files.end(), result.map_files.begin(), result.map_files.end());
      return;
    }
    intake::NotedResults parts(catalogue_);
    result.geometry = map.mosaic.geometry;
    result.seams = map::measure_seams(map.mosaic, &parts);
    result.grid = map::overview(map.mosaic, {});
    result.plane = map::mean_plane(*result.grid);
    exports::export_grid(*result.grid, result.suffix, options_.out);
    exports::export_map(map.mosaic, place, options_.max_vertices, options_.out, &parts, result);
    catalogue_.put_result(digest, bytes_of_map(result, parts.noted()));
  }

 private:
  bool keep(std::uint64_t digest, report::StripResult& result) {
    const auto known = catalogue_.result(digest);
    report::StripResult kept = result;
    std::set<std::uint64_t> parts;
    if (!known || !take_map(*known, kept, parts)) return false;
    for (const std::string& name : map_files(kept)) {
      if (!before_.files.contains(name)) return false;
    }
    catalogue_.keep_results(parts);
    result = std::move(kept);
    return true;
  }

  const GroundOptions& options_;
  const RunRecord& before_;
  intake::Catalogue& catalogue_;
};

void merge_and_export(const GroundOptions& options, const report::Report& report, const exports::Anchors* anchors,
                      const RunRecord& before, intake::Catalogue& catalogue, report::StripResult& result,
                      std::ostream& messages) {
  const intake::Strip& strip = result.strip;
  const exports::Georeference place = exports::georeference_of(report.flight, strip, anchors);
  result.colmap = exports::write_colmap_model(report.flight, strip, options.out / ("colmap" + result.suffix));
  const auto map = map::merge_strip(report.flight, strip, views_of(report, strip), catalogue, {},
                                    host::Progress(messages, "Merging strip " + std::to_string(strip.id)));
  host::LongPhases phases(messages);
  phases("Writing the map of strip " + std::to_string(strip.id));
  exports::export_track(report.flight, place, options.out, result);
  if (!map) return;
  result.map = map->statistics;
  result.balance = map->balance;
  MapExport(options, before, catalogue)(*map, place, result);
  if (!options.lay_holes) result.grid->laid = {};
  result.errors = map->mosaic.errors;
  result.usual_errors = map::usual_parts(*result.grid, result.errors);
  if (!options.colour.empty()) {
    exports::write_colour_ortho(report.flight, place, options.colour, options.out, result, messages);
  }
  exports::export_points_and_footprints(report.flight, place, options.out, result);
}

std::map<std::int64_t, map::Balance> balance_of(const report::Report& report) {
  std::map<std::int64_t, map::Balance> balance;
  for (const report::StripResult& strip : report.strips) balance.insert(strip.balance.begin(), strip.balance.end());
  return balance;
}

void find_landing_sites(const GroundOptions& options, const report::Report& report,
                        const landing::LandingLimits& limits, report::StripResult& result) {
  const auto control = std::find_if(report.control.begin(), report.control.end(),
                                    [&](const control::StripControl& c) { return c.strip == result.strip.id; });
  result.landing = landing::landing_of(result, control == report.control.end() ? nullptr : &*control, limits);
  if (result.landing->map) landing::export_landing(*result.landing->map, options.out, result);
}

void share(const GroundOptions& options, const report::Report& report, const exports::Anchors* anchors) {
  std::vector<const exports::ExportedStrip*> strips;
  for (const report::StripResult& strip : report.strips) strips.push_back(&strip);
  exports::write_shared_catalogue(options.catalogue, mission_of(options), report.flight, strips, anchors);
}

void keep_record(const GroundOptions& options, const report::Report& report, const RunRecord& before,
                 std::uint64_t inputs) {
  const std::vector<std::string> files = result_files(report);
  remove_other_results(options.out, files, before);
  RunRecord record = record_of(options.out, files, before);
  record.inputs = inputs;
  record.outbox = name_of_outbox(options.outbox);
  record.said = summary_of(options, report);
  if (!options.acknowledge.empty()) record.acknowledgements = intake::acknowledgements_of(report.outbox);
  write_record(record, options.out);
}

/// A mistaken number would leave a strip without its place.
void require_strips_of_anchors(const GroundOptions& options, const exports::Anchors& anchors,
                               const intake::Flight& flight) {
  std::string there;
  for (const auto& [id, strip] : flight.strips) there += (there.empty() ? "" : ", ") + std::to_string(id);
  for (const exports::StripAnchor& anchor : anchors.strips) {
    if (flight.strips.contains(anchor.strip)) continue;
    throw std::runtime_error(options.anchor.string() + " anchors strip " + std::to_string(anchor.strip) +
                             ", which has not come down; there is " + (there.empty() ? "none" : "strip " + there) +
                             ": name one of these, or leave the entry out until it comes");
  }
}

}  // namespace

void require_apart(const GroundOptions& options) {
  std::error_code error;
  const fs::path outbox = fs::weakly_canonical(fs::absolute(options.outbox), error);
  fs::path out = fs::weakly_canonical(fs::absolute(options.out), error);
  const fs::path beside = outbox.parent_path() / "ground";
  for (; out.has_relative_path(); out = out.parent_path()) {
    if (out != outbox) continue;
    throw host::WrongUsage("--out " + options.out.string() + " lies inside the downlink " + options.outbox.string() +
                           ", where the next run would take it for what came down: name a folder beside it, such as " +
                           beside.string());
  }
}

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
  if (!options.control.empty()) (void)control::read_control_file(options.control);
  std::optional<landing::LandingLimits> landing_limits;
  if (!options.landing.empty()) landing_limits = landing::read_landing_limits(options.landing);
  report::Report report;
  if (!options.flight_info.empty()) report.info = intake::read_flight_info(options.flight_info);
  if (!options.score.empty()) report.score = report::read_score(options.score);
  if (!options.map.empty()) report.map = std::make_shared<fixes::MapImage>(options.map);
  report.title = title_of(options);
  report.with_copies = options.keep_copies;
  std::optional<exports::Anchors> anchors;
  if (!options.anchor.empty())
    anchors = exports::read_anchors(options.anchor, report.info ? exports::flown_body(report.info->source) : nullptr);
  // Before anything is read: what comes later is news for the next run.
  const std::uint64_t inputs = digest_of_inputs(options);
  RunRecord before;
  std::unique_ptr<intake::Catalogue> opened = open_and_take_in(options, report, before, messages);
  intake::Catalogue& catalogue = *opened;
  decode_held(options, catalogue, report, messages);
  if (anchors && !options.more_comes) require_strips_of_anchors(options, *anchors, report.flight);
  remove_pages(options.out);
  if (!options.acknowledge.empty())
    intake::write_acknowledgements(intake::acknowledgements_of(report.outbox), options.acknowledge);

  report.target_overlap = target_overlap_of(options, report.info);
  report.has_reference = reference != nullptr;
  report.missing = intake::missing_of(report.flight);
  if (!report.missing.empty())
    messages << host::counted(report.missing.size(), "thing") << " missing: see the report\n";
  host::LongPhases phases(messages);
  if (!options.images.empty()) {
    phases("Comparing with the images of the camera");
    report::measure_image_quality(options.images, report);
  }
  for (const intake::Strip* strip : strips_with_poses_first(report.flight)) {
    report::StripResult& result = report.strips.emplace_back();
    result.strip = *strip;
    result.suffix = report.strips.size() == 1 ? "" : "-strip-" + std::to_string(strip->id);
    measure_strip(report, result);
    merge_and_export(options, report, anchors ? &*anchors : nullptr, before, catalogue, result, messages);
    if (landing_limits) find_landing_sites(options, report, *landing_limits, result);
    if (!options.keep_copies) std::erase_if(result.files, is_copy);
    if (reference) result.accuracy = report::measure_accuracy(report.flight, *strip, *reference);
    if (result.accuracy && !options.truth.empty())
      result.accuracy->on_map = report::measure_on_map(report.flight, *strip, *reference);
  }
  phases("Writing the report");
  report.has_viewer = viewer::viewer_available();
  report.tables = exports::write_flight_tables(report.flight, balance_of(report), options.out);
  host::update_file(options.out / "report.json", [&](std::ostream& out) { report::write_report_json(report, out); });
  host::update_file(options.out / "report.html", [&](std::ostream& out) { report::write_report_html(report, out); });
  if (report.has_viewer)
    host::update_file(options.out / "viewer.html", [&](std::ostream& out) { viewer::write_viewer_html(report, out); });
  if (!options.catalogue.empty()) share(options, report, anchors ? &*anchors : nullptr);
  fs::remove_all(tasks::work_folder(options.out));
  catalogue.forget_other_results();
  // Files that the catalogue has lost are news for the next run.
  const std::uint64_t known = catalogue.has_lost_files() ? 0 : inputs;
  if (!options.catalogue.empty()) catalogue.keep_mark(known);
  report.whole_quick_look = nullptr;
  opened.reset();  // its file is as the next run finds it
  if (!options.keep_copies) fs::remove(options.out / intake::catalogue_name);
  keep_record(options, report, before, known);
  return report;
}

std::string title_of(const GroundOptions& options) {
  if (!options.title.empty()) return options.title;
  const fs::path folder = fs::absolute(options.outbox).lexically_normal();
  fs::path name = folder.filename().empty() ? folder.parent_path().filename() : folder.filename();
  // The outbox of a flight has a fixed name: its flight's folder says more.
  if (name == "outbox" && folder.parent_path().has_filename()) name = folder.parent_path().filename();
  return name.string();
}

std::string mission_of(const GroundOptions& options) {
  return options.mission.empty() ? title_of(options) : options.mission;
}

std::vector<std::string> summary_of(const GroundOptions& options, const report::Report& report) {
  const report::ReportTotals sums = report::totals(report);
  std::vector<std::string> lines = report::camera_lines(report.flight);
  lines.push_back(std::to_string(sums.posed) + " of " + host::counted(sums.keyframes, "keyframe") + " posed, " +
                  std::to_string(sums.with_depth) + " with depth, " + host::counted(report.strips.size(), "strip"));
  for (std::string& line : report::nothing_lines(report)) lines.push_back(std::move(line));
  for (std::string& line : fixes::lines_of(report.fixes)) lines.push_back(std::move(line));
  for (std::string& line : fixes::lines_of(report.joined)) lines.push_back(std::move(line));
  if (!options.control.empty()) {
    for (std::string& line : control::lines_of(report.control)) lines.push_back(std::move(line));
  }
  for (const report::StripResult& strip : report.strips) {
    if (strip.landing) lines.push_back(landing::line_of(*strip.landing, strip.strip.id));
  }
  for (std::string& line : report::accuracy_lines(report)) lines.push_back(std::move(line));
  for (std::string& line : report::estimated_error_lines(report)) lines.push_back(std::move(line));
  lines.push_back("Report: " + (options.out / "report.html").string());
  lines.push_back(report.has_viewer ? "Viewer: " + (options.out / "viewer.html").string()
                                    : "No viewer: this build of ilp-ground has none (cmake says why)");
  return lines;
}

std::optional<std::vector<std::string>> summary_if_unchanged(const GroundOptions& options, std::ostream& messages) {
  if (options.afresh || fs::exists(tasks::work_folder(options.out))) return std::nullopt;
  RunRecord record = read_record(options.out);
  if (record.inputs == 0 || record.inputs != digest_of_inputs(options)) return std::nullopt;
  if (!options.catalogue.empty() && open_catalogue(options, true)->mark() != record.inputs) return std::nullopt;
  if (!keep_valid_files(options.out, options.check, record, messages)) {
    write_record(record, options.out);
    return std::nullopt;
  }
  if (!options.acknowledge.empty()) intake::write_acknowledgements(record.acknowledgements, options.acknowledge);
  messages << "nothing has changed since the run before\n";
  return record.said;
}

}  // namespace ilp::ground
